// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/sphere_tree/cover/cover_cells.h"
#include "geometry/sphere_tree/cover/deep_candidates.h"
#include "geometry/sphere_tree/shell_samples.h"

namespace poise::geometry {

/// A ball of the level under construction, in the frame of the cover.
struct CoverBall {
  Vec3f center = Vec3f::Zero();
  float radius = 0;           ///< 0 for a removed ball
  float signed_distance = 0;  ///< of the centre, negative inside; radius + signed_distance bounds the stand-off
  float price = 0;            ///< added to its bids for cells
  std::uint32_t parent = 0;
  std::vector<std::uint32_t> own;      ///< the cells that it owns, ascending
  std::vector<std::uint32_t> covered;  ///< all cells within it that its parent contains, ascending
};

/// A node of the level above. A closed one is a leaf and takes part unchanged.
struct CoverParent {
  Vec3f center = Vec3f::Zero();
  float radius = 0;
  bool closed = false;
  std::vector<std::uint32_t> own;  ///< the cells that its children own at first, ascending
  /// The cells inside this node and every node above it, which its children may own; ascending.
  std::vector<std::uint32_t> allowed;
};

struct LevelScore {
  double largest = 0;  ///< greatest distance of a covered sample outside the object
  double volume = 0;   ///< covered volume outside the object
};

/// Limits of the work on a level.
struct LevelSettings {
  int bids = 12;       ///< rounds of at least 1: cells are assigned to the ball with the lowest bid, then balls move
  int iterations = 6;  ///< most iterations of shrinking
  int redone = 0;      ///< attempts to rebuild the worst families
  /// Price of a larger radius than the others', as a share of the stand-off; 0: prices equalise the stand-offs instead.
  double equal_sizes = 0;
};

/// Computes the balls of one level, at most kTreeBranching below each parent, so that every cell is inside a ball whose
/// parent contains the cell, and the balls stand out little: docs/sphere-trees.md, "How a level is made". One thread at
/// a time; several objects may share cells, samples and mesh.
class LevelCover {
  // Invariant: count_[i] is the number of balls with a radius above 0 (closed parents included) that contain sample i,
  // and total_ is the sum of weight_[i] over samples with a positive count.
 public:
  LevelCover(const CoverCells& cells, const ShellSamples& samples, const TriangleBvh& bvh, const CoverFrame& frame,
             const std::vector<DeepPoint>& points, const std::vector<CoverParent>& parents);

  /// Improves balls, of which each open parent needs at least one. Calls `keep_going` after the first round and before
  /// each further one; when it returns false, the current balls contain every cell.
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
  /// The best balls found, each with the cells that it owns; together all cells that no closed parent contains.
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
  /// A sample has the weight 1 + kFarWeight (distance / scale)^power, where the scale is a share of the largest
  /// distance that is covered now.
  void weigh(double power);
  [[nodiscard]] LevelScore score() const;
  [[nodiscard]] double contribution(const CoverBall& ball) const;
  void gather_samples(const Vec3f& center, float from, float to);

  // Balls (level_balls.cpp).
  [[nodiscard]] float signed_distance(const Vec3f& at) const;
  void fit(CoverBall& ball, const std::vector<std::uint32_t>& cells, float step);
  void find_covered(CoverBall& ball, const std::vector<std::uint32_t>& needed) const;
  bool halve(const CoverBall& ball, const std::vector<std::uint32_t>& cells, Halves& best);

  // Bidding and shrinking (level_cover.cpp).
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
  std::vector<std::uint8_t> held_;                  ///< cells inside a closed parent
  std::vector<std::uint16_t> holders_;              ///< number of balls that contain a cell, during shrinking
  std::vector<float> least_bid_;
  std::vector<std::uint32_t> winner_;

  std::vector<std::uint32_t> count_;  ///< of balls that hold a sample, and kReadBeyond zeros
  std::vector<std::int32_t> weight_;
  std::int64_t total_ = 0;
  float most_bound_ = 0;  ///< of radius + signed distance, for centres that are tried

  std::vector<CoverBall> best_;
  double best_value_ = 0;
  LevelScore first_;

  CellSet set_;
  std::vector<std::uint32_t> near_ids_;  ///< of samples, with room for all and kReadBeyond more
  PointList near_;
  std::vector<std::int32_t> near_weight_;
};

}  // namespace poise::geometry
