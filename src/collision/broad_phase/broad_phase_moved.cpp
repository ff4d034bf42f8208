// SPDX-License-Identifier: MIT
#include <algorithm>
#include <iterator>
#include <utility>

#include "collision/broad_phase/broad_phase.h"
#include "collision/broad_phase/broad_phase_cells.h"
#include "collision/broad_phase/near_kernel.h"
#include "collision/broad_phase/resting_grid.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::collision {
namespace {

constexpr std::size_t kMovedGrain = 4;
constexpr std::size_t kInsertGrain = 8192;
// Pairs stay that no longer overlap: at most so many, as a share of those that were found. Chosen.
constexpr std::size_t kAddedShare = 16;

bool in_order(const CandidatePair& a, const CandidatePair& b) {
  return std::pair(a.low, a.high) < std::pair(b.low, b.high);
}

bool may_pair(const MotionBound& a, const MotionBound& b) {
  return (a.dynamic || b.dynamic) && meet(a.group, a.collides_with, b.group, b.collides_with);
}

}  // namespace

// Partners of a bound that has moved, into scratch.resting: among those in the grid, where they were at find(), all
// others that have moved, and what rests. A pair of two that have moved now is found by the first of them. False if
// there are more to look at than `room`.
bool BroadPhase::find_partners_anywhere(const MotionBound& self, std::span<const MotionBound> bounds,
                                        std::span<const std::uint32_t> moved_now, std::uint32_t room,
                                        const RestingGrid* resting, Scratch& scratch) const {
  std::vector<Partner>& partners = scratch.resting;
  partners.clear();
  RangeList& ranges = scratch.ranges;
  ranges.count = scratch.of_own_grid = 0;
  if (!self.center_m.allFinite()) return false;
  for (const int grid : used_grids_) {
    if (!list_grid(self.center_m, self.radius_m, grid, ranges)) return false;
  }
  const std::span<const NearRange> listed = std::span(ranges.list).first(ranges.count);
  std::size_t count = 0;
  for (const NearRange& range : listed) count += range.end - range.begin;
  if (count > room) return false;
  room -= static_cast<std::uint32_t>(count);
  const NearCount near =
      list_near(near_.balls(), near_ball(self.center_m, self.radius_m, false), listed, scratch.hits.data());
  const auto add = [&](const auto& other) {
    const double beyond = beyond_m2(self, other);
    if (overlap(beyond)) partners.push_back({beyond, other.slot});
  };
  for (const std::uint32_t e : std::span(scratch.hits).first(near.listed)) {
    const Entry& other = entries_[e];
    if (other.slot != self.slot && (self.dynamic || other.dynamic) &&
        meet(self.group, self.collides_with, other.group, other.collides_with))
      add(other);
  }
  for (const std::span<const std::uint32_t> others : {std::span<const std::uint32_t>(moved_before_), moved_now}) {
    for (const std::uint32_t i : others) {
      if (may_pair(self, bounds[i])) add(bounds[i]);
    }
  }
  if (resting == nullptr || !self.dynamic) return true;
  const std::size_t left =
      resting->visit_near(self.center_m, self.radius_m, room, [&](std::uint32_t slot, const RestingGrid::Entry& other) {
        const double beyond = beyond_m2(self, other);
        if (overlap(beyond) && meet(self.group, self.collides_with, other.group, other.collides_with))
          partners.push_back({beyond, slot});
      });
  return left == 0;
}

// Counts what is added as partners of both; planes are not counted, since find() leaves out none. False if a body may
// have come to more partners than it may keep. (A pair that find() would now find by the other body's search is counted
// where it was, so a body at the limit may have a partner or so too many.)
bool BroadPhase::gain(std::span<const CandidatePair> added, std::span<const PlaneBound> planes, std::size_t most,
                      parallel::Executor& executor) {
  for (const Scratch& scratch : scratch_) most_found_ = std::max(most_found_, scratch.most_found);
  std::size_t most_gained = 0;
  for (const CandidatePair& pair : added) {
    const auto is_one = [&](const PlaneBound& plane) { return plane.slot == pair.low || plane.slot == pair.high; };
    if (std::any_of(planes.begin(), planes.end(), is_one)) continue;
    if (pair.high >= gained_.size()) parallel::resize(executor, gained_, std::size_t{2} * pair.high + 1);
    for (const std::uint32_t slot : {pair.low, pair.high})
      most_gained = std::max<std::size_t>(most_gained, ++gained_[slot]);
  }
  return most_found_ + most_gained <= most;
}

// Inserts few into the sorted pairs, all in order and none of them there: what lies between two of them is copied as it
// is.
void BroadPhase::insert_pairs(std::span<const CandidatePair> added, parallel::Executor& executor) {
  const std::span<const CandidatePair> pairs = sorted_pairs();
  parallel::grow_anew(in_segments_, pairs.size() + added.size());
  parallel::for_ranges(
      executor, {pairs.size(), kInsertGrain}, [&](std::size_t range, std::size_t begin, std::size_t end) {
        auto from = pairs.begin() + static_cast<std::ptrdiff_t>(begin);
        const auto past = pairs.begin() + static_cast<std::ptrdiff_t>(end);
        // Those before the first of all pairs belong to the first range.
        auto next = range == 0 ? added.begin() : std::lower_bound(added.begin(), added.end(), *from, in_order);
        auto to = in_segments_.begin() + static_cast<std::ptrdiff_t>(begin) + (next - added.begin());
        const auto last = end == pairs.size() ? added.end() : std::lower_bound(next, added.end(), *past, in_order);
        for (; next != last; ++next) {
          const auto place = std::lower_bound(from, past, *next, in_order);
          to = std::copy(from, place, to);
          *to++ = *next;
          from = place;
        }
        std::copy(from, past, to);
      });
  sorted_.swap(in_segments_);
  pair_count_ += added.size();
}

std::optional<BroadPhase::Result> BroadPhase::find_moved(std::span<const MotionBound> bounds,
                                                         std::span<const std::uint32_t> moved,
                                                         std::span<const PlaneBound> planes,
                                                         const PartnerLimits& limits, parallel::Executor& executor,
                                                         const RestingGrid* resting) {
  if (moved_.empty()) {
    const std::size_t slots = gained_.size();
    gained_.clear();
    parallel::resize(executor, gained_, slots);
  }
  moved_before_.clear();
  std::set_difference(moved_.begin(), moved_.end(), moved.begin(), moved.end(), std::back_inserter(moved_before_));
  moved_.clear();
  std::merge(moved_before_.begin(), moved_before_.end(), moved.begin(), moved.end(), std::back_inserter(moved_));
  const std::uint32_t most = limits.crowds != nullptr ? CrowdedBodies::kLeast : limits.of_body;
  if (moved_.size() > most_moved(bounds.size()) || most_found_ > most) return std::nullopt;
  make_scratch(bounds.size(), limits.of_body, executor);
  parallel::Tickets points;
  parallel::Tickets too_many;
  parallel::parallel_for(executor, moved.size(), kMovedGrain, [&](std::size_t begin, std::size_t end, int worker) {
    Scratch& scratch = scratch_[static_cast<std::size_t>(worker)];
    Collector found(found_, points);
    const auto add = [&](std::uint32_t a, std::uint32_t b) {
      const std::span<const CandidatePair> known = sorted_pairs();
      if (!std::binary_search(known.begin(), known.end(), CandidatePair{std::min(a, b), std::max(a, b)}, in_order))
        found.add(a, b);
    };
    for (std::size_t k = begin; k < end; ++k) {
      const MotionBound& self = bounds[moved[k]];
      if (!find_partners_anywhere(self, bounds, moved.subspan(k + 1), most_tests(limits.of_body), resting, scratch)) {
        too_many.take();
        return;
      }
      scratch.most_found = std::max(scratch.most_found, scratch.resting.size());
      for (const Partner& partner : scratch.resting) add(self.slot, partner.slot);
      for_planes(self, planes, [&](std::uint32_t plane) { add(self.slot, plane); });
    }
    found.flush();
  });
  const std::size_t count = points.take(0);
  const std::size_t room = std::min(found_pairs_ + found_pairs_ / kAddedShare, limits.of_all);
  if (too_many.take(0) > 0 || count > found_.size() || pair_count_ + count > room) return std::nullopt;

  // One of the grid may be found where it was and where it is. These are few beside all pairs.
  const auto first = found_.begin();
  std::sort(first, first + static_cast<std::ptrdiff_t>(count), in_order);
  const auto past = std::unique(first, first + static_cast<std::ptrdiff_t>(count));
  const auto added = std::span<const CandidatePair>(found_).first(static_cast<std::size_t>(past - first));
  if (!gain(added, planes, most, executor)) return std::nullopt;
  if (!added.empty()) insert_pairs(added, executor);
  Result result;
  result.pairs = sorted_pairs();
  result.looked_at = moved.size();
  return result;
}

}  // namespace poise::collision
