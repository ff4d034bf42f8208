// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "collision/manifold/manifold_point.h"
#include "poise/types.h"

namespace poise::collision {

/// A place where two surfaces face each other, and what tells it from others.
struct FoundPoint {
  static constexpr std::uint64_t kNoCorner = ~std::uint64_t{0};

  Vec3 normal, point_m;  ///< as in Patch
  double gap_m;
  std::uint64_t order;   ///< where the features stand in the meshes: the lower one goes first among equals
  std::uint64_t corner;  ///< names the corner that lies over or beneath a face; kNoCorner for other features
  std::uint32_t rank;    ///< of two that are one place and equally far, the lower one stays
  bool in_groove;        ///< as in FacingFeatures
};

/// The places found for a pair, in bounded room. Invariant: no two of them are one place, that is, nearer than the
/// merging distance with directions less than kOneWay apart. When the room is full, those that span the others are kept
/// (per direction the nearest and the farthest ones along eight axes).
class PointList {
 public:
  static constexpr double kOneWay = 0.9396926207859084;  ///< cosine of 20 degrees: directions within it answer as one
  static constexpr std::size_t kRoom = 64;

  /// `size_m` of the smaller body (its bounding radius, > 0): places nearer than 1e-3 of it are one, gaps within 2e-6
  /// of it equal.
  explicit PointList(double size_m = 1) { clear(size_m); }
  void clear(double size_m) {
    merge_m_ = 1e-3 * size_m;
    tie_m_ = 2e-6 * size_m;
    least_gap_m_ = std::numeric_limits<double>::infinity();
    count_ = 0;
  }

  void add(const FoundPoint& place);
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Of all that were added; infinite where there are none.
  [[nodiscard]] double least_gap_m() const { return least_gap_m_; }
  /// Are the directions of all that overlap within kOneWay of this one? True where there are none.
  [[nodiscard]] bool overlaps_only_along(const Vec3& normal) const;

  /// At most kMaxPatches of those with gaps below `reach_m`, that hold the pair as all of them would. A corner beneath
  /// several faces counts for the one that it is nearest to, but in a groove. Directions more than 20 degrees apart
  /// share the room, the deepest first. Of one direction: the deepest, the one farthest from it, the one that makes the
  /// largest triangle with them, and the one that adds most to that. The answer does not depend on the order of adding
  /// but for what was merged.
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
  std::size_t pick(const Group& group, std::size_t most, std::array<std::uint8_t, kMaxManifoldPoints>& out) const;
  void thin_out();

  double merge_m_, tie_m_, least_gap_m_;
  std::size_t count_;
  std::array<FoundPoint, kRoom> point_;  // the first count_ are set
};

}  // namespace poise::collision
