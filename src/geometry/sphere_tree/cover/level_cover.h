// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/sphere_tree/cover/cover_cells.h"
#include "geometry/sphere_tree/cover/deep_candidates.h"
#include "geometry/sphere_tree/shell_samples.h"

namespace poise::geometry {

/// A ball of the level that is being made. In the frame of the cover.
struct CoverBall {
  Vec3f center = Vec3f::Zero();
  float radius = 0;           ///< 0 for a ball that is no longer there
  float signed_distance = 0;  ///< of the centre, negative inside; radius + this is how far it may stand out
  float price = 0;            ///< added to its bids for cells
  std::uint32_t parent = 0;
  std::vector<std::uint32_t> own;      ///< the cells that it answers for, ascending
  std::vector<std::uint32_t> covered;  ///< all that it holds of those that its parent may pass on, ascending
};

/// A node of the level above. A closed one is a leaf and takes part as itself.
struct CoverParent {
  Vec3f center = Vec3f::Zero();
  float radius = 0;
  bool closed = false;
  std::vector<std::uint32_t> own;  ///< the cells that its children answer for at first, ascending
  std::vector<std::uint32_t>
      allowed;  ///< all that it and every node above it hold: what its children may answer for, ascending
};

struct LevelScore {
  double largest = 0;  ///< greatest distance of a covered sample
  double volume = 0;   ///< of what is covered outside the object
};

/// How long a level is worked on.
struct LevelSettings {
  int bids = 12;       ///< rounds in which cells go to the ball that bids least, and balls move; at least 1
  int iterations = 6;  ///< of shrinking to what no other ball holds, at most
  int redone = 0;      ///< attempts to make the worst families anew
  double equal_sizes =
      0;  ///< price of being larger than others, as a share of the stand-off; 0 = prices even out the stand-offs
};

/// Makes the balls of one level, at most kTreeBranching below each parent, so that every cell is held by a ball whose
/// parent may pass it on, and little stands out: docs/sphere-trees.md, "How a level is made". One thread at a time;
/// several may share cells, samples and mesh.
class LevelCover {
  // Invariant: count_[i] is the number of balls (closed parents included) that hold sample i while their radius is
  // above 0, and total_ the sum of weight_[i] over samples with a count.
 public:
  LevelCover(const CoverCells& cells, const ShellSamples& samples, const TriangleBvh& bvh, const CoverFrame& frame,
             const std::vector<DeepPoint>& points, const std::vector<CoverParent>& parents);

  /// Improves balls, of which each open parent needs at least one. `keep_going` is asked after the first round and
  /// before each further one; what there is when it says no holds every cell.
  template <class KeepGoing>
  void improve(std::vector<CoverBall> balls, const LevelSettings& settings, KeepGoing&& keep_going) {
    begin(std::move(balls));
    bid(0, settings);
    for (int round = 1; round < settings.bids && keep_going(); ++round) bid(round, settings);
    begin_iterations();
    for (int sweep = 0; sweep < settings.iterations && keep_going(); ++sweep) {
      if (!shrink(sweep)) break;
    }
    if (keep_going()) redo_worst(settings.redone);
  }
  /// The best balls found, each with the cells that it answers for; together all cells that no closed parent holds.
  std::vector<CoverBall> take_best(LevelScore* score = nullptr);

 private:
  struct Halves {
    std::vector<std::uint32_t> first, second;
    Vec3f first_center = Vec3f::Zero();
    Vec3f second_center = Vec3f::Zero();
  };

  void begin(std::vector<CoverBall> balls);
  void bid(int round, const LevelSettings& settings);
  void begin_iterations();
  bool shrink(int sweep);

  // Samples (level_samples.cpp).
  void count(const CoverBall& ball, int change);
  /// A sample counts 1 + kFarWeight (distance / scale)^power, with the scale a share of the largest distance that is
  /// covered now.
  void weigh(double power);
  [[nodiscard]] LevelScore score() const;
  [[nodiscard]] double contribution(const CoverBall& ball) const;
  void gather_samples(const Vec3f& center, float from, float to);

  // Balls (level_balls.cpp).
  [[nodiscard]] float signed_distance(const Vec3f& at) const;
  void fit(CoverBall& ball, const std::vector<std::uint32_t>& cells, float step);
  void find_covered(CoverBall& ball, const std::vector<std::uint32_t>& needed) const;
  bool halve(const CoverBall& ball, const std::vector<std::uint32_t>& cells, Halves& best);

  // Bidding and sweeps (level_cover.cpp).
  void assign();
  void set_prices(const LevelSettings& settings);
  void remember();
  void drop_empty();
  void split_for_free_points();
  std::vector<std::uint32_t> take_out(CoverBall& ball);
  void put_in(CoverBall& ball, const std::vector<std::uint32_t>& needed);
  bool split_in_two(CoverBall& ball, const std::vector<std::uint32_t>& needed, CoverBall& second);
  void fill_free_points();
  void swap_poor_for_needed();
  [[nodiscard]] double largest_of(const CoverBall& ball) const;
  bool redo(std::uint32_t parent, std::uint64_t seed);
  void redo_worst(int attempts);
  bool swap(std::uint32_t poor, std::uint32_t worst, const std::vector<std::uint32_t>& family);

  const CoverCells& cells_;
  const ShellSamples& samples_;
  const TriangleBvh& bvh_;
  const CoverFrame& frame_;
  const std::vector<DeepPoint>& points_;
  const std::vector<CoverParent>& parents_;

  std::vector<CoverBall> balls_;
  std::vector<std::vector<std::uint32_t>> family_;  ///< balls of each parent
  std::vector<std::uint8_t> held_;                  ///< by a closed parent
  std::vector<std::uint16_t> holders_;              ///< balls that hold a cell, while sweeping
  std::vector<float> least_bid_;
  std::vector<std::uint32_t> winner_;

  std::vector<std::uint16_t> count_;
  std::vector<std::int32_t> weight_;
  std::int64_t total_ = 0;
  float most_bound_ = 0;  ///< of radius + signed distance, for places that are tried

  std::vector<CoverBall> best_;
  double best_value_ = 0;
  LevelScore first_;

  CellSet set_;
  PointList near_;
  std::vector<std::int32_t> near_weight_;
};

}  // namespace poise::geometry
