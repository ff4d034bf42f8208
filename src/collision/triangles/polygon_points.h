// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "collision/front/pair_frame.h"
#include "collision/front/pair_refinement.h"
#include "collision/triangles/point_list.h"
#include "collision/triangles/polygon_sums.h"
#include "collision/triangles/surface_descent.h"
#include "collision/triangles/triangle_pair.h"

namespace poise::collision {

/// Contact points nearer than this count for a pair whose surfaces are `least_m` apart, or overlap (<= 0); at most the
/// frame's margin. Where triangles are small many lie near each other: with every 64 pairs of them that were
/// `looked_at`, half as far is enough.
double points_reach_m(const PairFrame& frame, double least_m, std::uint32_t looked_at = 0);
/// Features count as passed through each other up to this depth while triangles are looked through; halved likewise.
double points_beneath_m(const PairFrame& frame, std::uint32_t looked_at = 0);

/// Adds facing features as a contact point; `order` holds the triangle of a in its high half and that of b in its low
/// half.
void add_facing_point(const FacingFeatures& feature, std::uint64_t order, PointList& points);

/// Triangles of one body at the crossing, each once. Of those that share a corner or a side the first stands for it.
class CrossingTriangles {
 public:
  static constexpr std::size_t kMost = 24;
  void add(const PlacedSurface& on, std::uint32_t index);
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] const PlacedTriangle& operator[](std::size_t i) const { return triangle_[i]; }
  [[nodiscard]] const ShapeSurface::NearTriangle& near(std::size_t i) const { return near_[i]; }
  /// All of them, for compare_triangles: the last one fills the rest.
  static constexpr std::size_t kRows = (kMost + NearRows::kPairs - 1) / NearRows::kPairs;
  void fill(std::array<NearRows, kRows>& rows) const;

 private:
  std::size_t count_ = 0;
  std::uint64_t vertex_bits_ = 0;                ///< of the lowest bits of all that follow
  std::array<std::uint32_t, 3 * kMost> vertex_;  ///< of their corners
  std::array<PlacedTriangle, kMost> triangle_;
  std::array<ShapeSurface::NearTriangle, kMost> near_;
};

/// What follows when all triangles were looked through, for the manifold of a pair. About 30 KB.
struct DeeperSearch {
  double beneath_m = 0;    ///< features are searched so deep
  bool on = false;         ///< the pair needs it
  std::uint32_t rows = 0;  ///< done
  CrossingTriangles of_a, of_b;
  std::array<NearRows, CrossingTriangles::kRows> rows_of_b;
};

/// Whether bodies that penetrate deeper than their contact points reach are searched again along the curve where the
/// surfaces cross. Also removes what only seems to overlap.
void begin_deeper(const PairFrame& frame, const PlacedSurface& on_a, const PlacedSurface& on_b, const PolygonSums& sums,
                  const PairContact& contact, std::uint32_t looked_at, DeeperSearch& search, PointList& points);
/// One row of at most 24 pairs of triangles, by the frame of the descent; false when there are no more. Adds to
/// `points`; allocates nothing.
bool look_deeper(const PlacedSurface& on_a, const PlacedSurface& on_b, const SurfaceDescent& descent,
                 DeeperSearch& search, PointList& points);

/// The manifold of a pair, from the contact points of its triangles and from its impact contact: that is the only point
/// where no others were found. Adds to `points`.
ManifoldPoints manifold_points_of(const PairFrame& frame, const Mat3& rotation_a, const PairContact& contact,
                                  std::uint32_t looked_at, PointList& points);

}  // namespace poise::collision
