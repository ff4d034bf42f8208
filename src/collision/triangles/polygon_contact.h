// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "collision/front/front.h"
#include "collision/front/pair_frame.h"
#include "collision/front/pair_refinement.h"
#include "collision/triangles/point_list.h"
#include "collision/triangles/polygon_sums.h"

namespace poise::collision {

/// A set of pairs of numbers that were already processed. Invariant: nothing is removed, so a pair that is missing when
/// the set is full is never added.
class MetPairs {
 public:
  enum class Answer : std::uint8_t { New, Met, NoRoom };
  MetPairs() { keys_.fill(kNone); }
  Answer meet(std::uint32_t a, std::uint32_t b);

 private:
  static constexpr std::size_t kSlots = 1024;
  static constexpr std::size_t kMost = 768;
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  std::array<std::uint64_t, kSlots> keys_;
  std::size_t count_ = 0;
};

/// A triangle of a placed surface and the box of its part that counts.
struct BoxedTriangle {
  PlacedTriangle triangle;
  Vec3 low_m, high_m;
};

/// Triangles of two leaves that are looked at together, those of a against those of b row by row.
struct TriangleBlock {
  static constexpr std::uint32_t kMost = 64;  ///< of each: as many as a leaf of a well-built tree has
  std::array<BoxedTriangle, kMost> a, b;
  std::size_t count_a = 0, count_b = 0;
  std::size_t rows = 0;      ///< of a that are done
  double beneath_m = 0;      ///< how far two features may have passed each other
  bool in_progress = false;  ///< a piece ended within it
};

/// The polygon level of a pair in progress: one worker, in bounded pieces. About 64 KB, on the stack.
struct PolygonProgress {
  SegmentRef reading;        ///< of the front of leaves
  bool roots = false;        ///< the front is the two roots
  std::uint32_t offset = 0;  ///< entries of it that are done
  std::uint32_t block = 0;   ///< blocks of the entry that are done
  std::uint32_t place = 0;   ///< of the entry in the whole front
  PlacedSurface on_a, on_b;
  double most_m = 0;  ///< the surfaces are not farther apart than this, or than the margin
  PolygonSums sums;
  MetPairs met;
  bool rests = true;  ///< the manifold of the pair is wanted
  PointList points;
  TriangleBlock triangles;  ///< of the block
  double work = 0;          ///< of this piece so far, in node-pair expansions

  /// Facing features beyond this distance do not count for an impact.
  [[nodiscard]] double reach_m(const PairFrame& frame) const;
  /// The same for contact points of resting contact.
  [[nodiscard]] double points_reach_m(const PairFrame& frame) const;
};

/// Adds the level of polygons to a pair at level 0 whose `deepest` is set, where a shape has a surface and the trees of
/// both end within `max_level`. b may be a plane.
void allow_polygons(const Shape& a, const Shape& b, Level max_level, PairLevel& pair);

/// What the polygons of a front of leaves (none: the two roots) cost, in node-pair expansions; at most 2^32 - 1.
std::uint32_t polygon_units(const Shape& a, const Shape& b, std::span<const FrontPool> pools, SegmentRef front);

/// With `rests` false no manifold is computed.
void begin_polygons(const PairFrame& frame, const Mat3& rotation_a, const PairLevel& pair, const LevelContact& found,
                    PolygonProgress& progress, bool rests = true);

/// Goes on for about `units`: at most one triangle of a against a block of b's more. Bounded, allocates nothing. More
/// or Complete.
Quantum run_polygons(const PairFrame& frame, std::span<const FrontPool> pools, std::uint32_t units,
                     PolygonProgress& progress);

/// Stores the complete level and its manifold in the pair. The front stays that of the leaves.
void publish_polygons(const PairFrame& frame, const Mat3& rotation_a, PolygonProgress& progress, PairLevel& pair,
                      LevelContact& found);

}  // namespace poise::collision
