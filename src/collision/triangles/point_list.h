// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "collision/manifold/manifold_point.h"
#include "poise/types.h"

namespace poise::collision {

/// A candidate contact point: a point where two surfaces face each other.
struct FoundPoint {
  static constexpr std::uint64_t kNoCorner = ~std::uint64_t{0};

  Vec3 normal, point_m;  ///< as in ManifoldPoint
  double gap_m;
  std::uint64_t order;   ///< order of the features in the meshes: the lower one wins ties
  std::uint64_t corner;  ///< id of the corner that lies over or beneath a face; kNoCorner for other features
  std::uint32_t rank;    ///< of two merged points with equal gaps, the one with the lower rank stays
  bool in_groove;        ///< as in FacingFeatures
};

/// Candidate contact points of a pair, of bounded capacity. Invariant: no two are nearer than the merging distance with
/// directions less than kOneWay apart. When the list is full, only the points that span the others stay (per direction
/// the nearest, and the ones that are farthest from it along eight axes, by weight as of choose()).
class PointList {
 public:
  static constexpr double kOneWay = 0.9396926207859084;  ///< cosine of 20 degrees: normals within it count as one
  static constexpr std::size_t kRoom = 64;

  /// `size_m` of the smaller body (its bounding radius, > 0): points nearer than 1e-3 of it are merged, gaps within
  /// 2e-6 of it count as equal.
  explicit PointList(double size_m = 1) { clear(size_m); }
  void clear(double size_m) {
    merge_m_ = 1e-3 * size_m;
    tie_m_ = 2e-6 * size_m;
    least_gap_m_ = std::numeric_limits<double>::infinity();
    count_ = 0;
  }

  void add(const FoundPoint& point);
  /// Forgets all with gaps below `gap_m`.
  void remove_below(double gap_m);
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Of all that were added; infinite where there are none.
  [[nodiscard]] double least_gap_m() const { return least_gap_m_; }
  /// True if the normals of all penetrating points are within kOneWay of this one, also where there are none.
  [[nodiscard]] bool overlaps_only_along(const Vec3& normal) const;

  /// At most kMaxManifoldPoints of those with gaps below `reach_m`, that support the pair as all of them would. A
  /// corner beneath several faces counts for the one that it is nearest to, but in a groove. Directions more than 20
  /// degrees apart share the manifold, the deepest first. Of one direction: the deepest, the one farthest from it, the
  /// one that makes the largest triangle with them, and the one that adds most to that, where lengths to points that do
  /// not touch count less. The result does not depend on the order of add() except by merging.
  [[nodiscard]] ManifoldPoints choose(double reach_m) const;

 private:
  struct Group {
    std::array<std::uint8_t, kRoom> member;
    std::size_t count = 0;
    Vec3 normal;
  };
  struct Groups {
    std::array<Group, kMaxManifoldPoints> group;
    std::size_t count = 0;
  };

  [[nodiscard]] bool better(const FoundPoint& a, const FoundPoint& b) const;
  [[nodiscard]] bool outdone(std::size_t index) const;
  void sort_into(double reach_m, Groups& groups) const;
  [[nodiscard]] std::size_t outermost_of_deepest(const Group& group) const;
  [[nodiscard]] double weight(const Group& group, std::size_t k) const;
  std::size_t pick(const Group& group, std::size_t most, std::array<std::uint8_t, kMaxManifoldPoints>& out) const;
  void thin_out();

  double merge_m_, tie_m_, least_gap_m_;
  std::size_t count_;
  std::array<FoundPoint, kRoom> point_;  // the first count_ are set
};

}  // namespace poise::collision
