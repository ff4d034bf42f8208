// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/cover/greedy_cover.h"

#include <algorithm>

#include "geometry/primitives/random.h"
#include "poise/sphere_tree.h"

namespace poise::geometry {
namespace {

/// Covers the same cells repeatedly with different stand-offs.
class Greedy {
  // Invariant: open_ has a 1 for each cell that no taken ball contains, and left_ is their number.
 public:
  Greedy(const CoverCells& cells, const std::vector<std::uint32_t>& members, std::size_t max_cells) {
    const std::size_t step = std::max<std::size_t>(1, members.size() / std::max<std::size_t>(1, max_cells));
    for (std::size_t i = 0; i < members.size(); i += step) {
      middles_.add(cells.middles.at(members[i]));
      reach_.push_back(cells.reach[members[i]]);
    }
  }

  [[nodiscard]] std::size_t size() const { return reach_.size(); }
  [[nodiscard]] Vec3f middle(std::size_t i) const { return middles_.at(i); }
  void add_point(const DeepPoint& place) { points_.push_back(place); }
  [[nodiscard]] std::size_t point_count() const { return points_.size(); }

  /// Covers the cells; the first ball is random if `random` is given.
  bool cover(float stand_off, Random* random, std::vector<DeepPoint>& taken) {
    taken.clear();
    open_.assign(size(), 1);
    left_ = static_cast<std::int32_t>(size());
    if (random != nullptr) {
      const std::size_t a = random->below(points_.size());
      const std::size_t b = random->below(points_.size());
      take(gain(points_[a], stand_off) >= gain(points_[b], stand_off) ? a : b, stand_off, taken);
    }
    // A gain can only shrink as cells are covered, so an old gain is an upper bound and the queue need not be rebuilt.
    queue_.clear();
    for (std::size_t k = 0; k < points_.size(); ++k) queue_.push_back({gain(points_[k], stand_off), k});
    std::make_heap(queue_.begin(), queue_.end(), worse);
    while (left_ > 0 && taken.size() < kTreeBranching && !queue_.empty()) {
      const auto balls_left = static_cast<std::int32_t>(kTreeBranching - taken.size());
      if (queue_.front().gain < (left_ + balls_left - 1) / balls_left) return false;
      std::pop_heap(queue_.begin(), queue_.end(), worse);
      Candidate& last = queue_.back();
      last.gain = gain(points_[last.place], stand_off);
      if (queue_.size() > 1 && worse(last, queue_.front())) {
        std::push_heap(queue_.begin(), queue_.end(), worse);
        continue;
      }
      const std::size_t place = last.place;
      queue_.pop_back();
      take(place, stand_off, taken);
    }
    return left_ == 0;
  }

 private:
  struct Candidate {
    std::int32_t gain;
    std::size_t place;
  };
  static bool worse(const Candidate& a, const Candidate& b) {
    return a.gain != b.gain ? a.gain < b.gain : a.place > b.place;
  }

  [[nodiscard]] std::int32_t gain(const DeepPoint& place, float stand_off) const {
    const float radius = place.depth + stand_off;
    return radius > 0 ? weight_of_balls_within(middles_, reach_, open_, place.center, radius) : 0;
  }
  void take(std::size_t index, float stand_off, std::vector<DeepPoint>& taken) {
    const DeepPoint& place = points_[index];
    const float radius = place.depth + stand_off;
    for (std::size_t i = 0; i < size(); ++i) {
      const float room = radius - reach_[i];
      if (open_[i] == 0 || room <= 0 || (middles_.at(i) - place.center).squaredNorm() > room * room) continue;
      open_[i] = 0;
      --left_;
    }
    taken.push_back(place);
  }

  PointList middles_;
  std::vector<float> reach_;
  std::vector<DeepPoint> points_;
  std::vector<std::int32_t> open_;
  std::vector<Candidate> queue_;
  std::int32_t left_ = 0;
};

}  // namespace

GreedyCover cover_greedily(const CoverCells& cells, const std::vector<std::uint32_t>& members,
                           const std::vector<DeepPoint>& points, const Vec3f& center, float radius,
                           const TriangleBvh& bvh, const CoverFrame& frame, std::uint64_t seed,
                           const GreedySettings& settings) {
  Random random(seed);
  Greedy greedy(cells, members, settings.cells);
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if ((points[i].center - center).squaredNorm() < radius * radius) near.push_back(i);
  }
  const std::size_t taken = std::min(near.size(), settings.points);
  for (std::size_t i = 0; i < taken; ++i)
    greedy.add_point(points[near[(i * near.size() + random.below(near.size())) / taken % near.size()]]);
  // Without a candidate of its own, a cell far from all others may need a huge ball.
  const std::size_t own = std::min(greedy.size(), settings.points / 4 + 1);
  for (std::size_t i = 0; i < own; ++i) {
    const Vec3f at = greedy.middle(i * greedy.size() / own);
    greedy.add_point({at, static_cast<float>(-bvh.signed_distance_m(frame.from(at)) / frame.diagonal_m)});
  }
  GreedyCover best;
  std::vector<DeepPoint> found;
  const auto try_cover = [&](float stand_off) {
    bool done = greedy.cover(stand_off, nullptr, found);
    for (int i = 0; i < settings.random_starts && !done; ++i) done = greedy.cover(stand_off, &random, found);
    if (done) best = {found, stand_off};
    return done;
  };
  float low = 0;
  float high = 0.001F;
  while (!try_cover(high) && high < 4) {
    low = high;
    high *= 1.6F;
  }
  for (int i = 0; i < settings.halvings; ++i) {
    const float middle = 0.5F * (low + high);
    (try_cover(middle) ? high : low) = middle;
  }
  return best;
}

}  // namespace poise::geometry
