// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "collision/front/front.h"
#include "collision/front/pair_frame.h"
#include "collision/front/pair_refinement.h"
#include "collision/triangles/point_list.h"
#include "collision/triangles/polygon_points.h"
#include "collision/triangles/polygon_sums.h"
#include "collision/triangles/surface_descent.h"
#include "collision/triangles/triangle_pair.h"

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

/// Triangles of a surface that were placed lately. Each has one slot, so results depend on the triangle alone.
class PlacedTriangles {
 public:
  PlacedTriangles() { index_.fill(ShapeSurface::kNone); }
  const PlacedTriangle& get(const PlacedSurface& on, std::uint32_t triangle) {
    const std::size_t slot = triangle % kSlots;
    if (index_[slot] != triangle) {
      place(on, triangle, placed_[slot]);
      index_[slot] = triangle;
    }
    return placed_[slot];
  }

 private:
  static constexpr std::size_t kSlots = 64;
  std::array<std::uint32_t, kSlots> index_;
  std::array<PlacedTriangle, kSlots> placed_;
};

/// What a polygon level does next.
enum class PolygonStage : std::uint8_t { Triangles, Contact, Deeper, Points, Done };

/// The polygon level of a pair in progress: one worker, in bounded pieces. About 130 KB, on the stack.
struct PolygonProgress {
  SegmentRef reading;        ///< of the front of leaves; two meshes need no front
  bool roots = false;        ///< the front is the two roots
  std::uint32_t offset = 0;  ///< entries of it that are done
  std::uint32_t block = 0;   ///< blocks of the entry that are done
  PlacedSurface on_a, on_b;
  SurfaceDescent descent;  ///< of two meshes
  PlacedTriangles placed_a, placed_b;
  double most_m = 0;            ///< the surfaces are not farther apart than this, or than the margin
  double beneath_m = 0;         ///< how far two features may have passed each other
  std::uint32_t looked_at = 0;  ///< pairs of triangles near each other
  PolygonSums sums;
  MetPairs met;
  bool rests = true;  ///< the manifold of the pair is wanted
  PointList points;
  PolygonStage stage = PolygonStage::Triangles;
  Mat3 rotation_a = Mat3::Identity();
  PairContact contact;  ///< of the leaves, then of the polygons
  DeeperSearch deeper;
  ManifoldPoints manifold_points;
  double work = 0;  ///< of this piece so far, in node-pair expansions

  [[nodiscard]] bool meshes() const { return on_a.surface != nullptr && on_b.surface != nullptr; }
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

/// Goes on for about `units`: at most 16 pairs of triangles, or 64 triangles against a ball or a plane, more. Bounded,
/// allocates nothing. More or Complete.
Quantum run_polygons(const PairFrame& frame, std::span<const FrontPool> pools, std::uint32_t units,
                     PolygonProgress& progress);

/// Stores the complete level and its manifold in the pair. The front stays that of the leaves.
void publish_polygons(const PolygonProgress& progress, PairLevel& pair, LevelContact& found);

}  // namespace poise::collision
