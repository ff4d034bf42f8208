// SPDX-License-Identifier: MIT
#include "world/candidate_cache.h"

#include <algorithm>
#include <utility>

#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kBoundGrain = 512;
// Bounds are cached larger by this share, chosen: bodies at rest stay inside for seconds, and there are a sixth more
// pairs.
constexpr double kWider = 0.05;
// A scene is calm when at most this share of its bodies has moved by a quarter of that since the bounds were cached.
constexpr double kRestless = 0.05;

bool same(const collision::PlaneBound& a, const collision::PlaneBound& b) {
  return a.normal == b.normal && a.height_m == b.height_m && a.slot == b.slot && a.group == b.group &&
         a.collides_with == b.collides_with;
}

}  // namespace

CandidateCache::Look CandidateCache::look(std::span<const collision::MotionBound> bounds,
                                          std::span<const collision::PlaneBound> planes, parallel::Executor& executor) {
  if (bounds.size() != bounds_.size() ||
      !std::equal(planes.begin(), planes.end(), planes_.begin(), planes_.end(), same))
    return {};
  // They are of no use but to wide bounds.
  left_.resize(wide_ ? collision::BroadPhase::most_moved(bounds.size()) : 0);
  parallel::Tickets changed;
  parallel::Tickets outside;
  parallel::Tickets restless;
  parallel::parallel_for(executor, bounds.size(), kBoundGrain, [&](std::size_t begin, std::size_t end, int) {
    std::size_t others = 0;
    std::size_t left = 0;
    std::size_t moved = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const collision::MotionBound& now = bounds[i];
      const collision::MotionBound& cached = bounds_[i];
      const double away_m = (now.center_m - cached.center_m).norm();
      others += now.slot == cached.slot && now.group == cached.group && now.collides_with == cached.collides_with &&
                        now.dynamic == cached.dynamic
                    ? 0U
                    : 1U;
      moved += away_m + now.radius_m - radius_m_[i] > 0.25 * kWider * radius_m_[i] ? 1U : 0U;
      if (away_m + now.radius_m <= cached.radius_m) continue;
      ++left;
      if (outside.next() >= left_.size()) continue;
      const std::size_t place = outside.take();
      --left;
      if (place < left_.size()) left_[place] = static_cast<std::uint32_t>(i);
    }
    if (others > 0) changed.take(others);
    if (left > 0) outside.take(left);
    if (moved > 0) restless.take(moved);
  });
  const auto most = static_cast<std::size_t>(kRestless * static_cast<double>(bounds.size()));
  const std::size_t left = outside.take(0);
  left_.resize(std::min(left, left_.size()));
  std::sort(left_.begin(), left_.end());
  return {changed.take(0) == 0, left, restless.take(0) <= most};
}

void CandidateCache::keep(const collision::MotionBound& bound, std::size_t i) {
  bounds_[i] = bound;
  radius_m_[i] = bound.radius_m;
  if (wide_) bounds_[i].radius_m *= 1.0 + kWider;
}

collision::BroadPhase::Result CandidateCache::find(
    collision::BroadPhase& broad_phase, std::span<const collision::MotionBound> bounds,
    std::span<const collision::PlaneBound> planes, std::span<const collision::SweptBound> swept,
    const collision::RestingGrid& resting, const collision::PartnerLimits& limits, parallel::Executor& executor) {
  if (!swept.empty()) {
    bounds_.clear();
    wide_ = false;
    return broad_phase.find(bounds, planes, limits, executor, swept, &resting);
  }
  const Look seen = look(bounds, planes, executor);
  const bool same_resting = std::exchange(resting_version_, resting.version()) == resting.version();
  if (wide_ && seen.same && same_resting && seen.left == left_.size()) {
    if (seen.left == 0) return found_;
    for (const std::uint32_t i : left_) keep(bounds[i], i);
    const auto found = broad_phase.find_moved(bounds_, left_, planes_, limits, executor, &resting);
    if (found) return found_ = *found;
  }
  wide_ = seen.calm && !bounds.empty();
  planes_.assign(planes.begin(), planes.end());
  bounds_.resize(bounds.size());
  radius_m_.resize(bounds.size());
  parallel::parallel_for(executor, bounds.size(), kBoundGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) keep(bounds[i], i);
  });
  found_ = broad_phase.find(bounds_, planes_, limits, executor, {}, &resting);
  if (wide_ && found_.discarded > 0) {
    // Which pairs are discarded is decided from the bounds of the frame.
    wide_ = false;
    found_ = broad_phase.find(bounds, planes, limits, executor, {}, &resting);
  }
  return found_;
}

}  // namespace poise::simulation
