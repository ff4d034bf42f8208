// SPDX-License-Identifier: MIT
#pragma once

#include "collision/front/pair_frame.h"
#include "collision/front/pair_refinement.h"
#include "collision/triangles/point_list.h"
#include "collision/triangles/polygon_sums.h"
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

/// What follows when all triangles were looked through, for the manifold of a pair.
struct DeeperSearch {
  double beneath_m = 0;    ///< features are searched so deep
  bool on = false;         ///< the pair needs it
  std::uint32_t rows = 0;  ///< done
};

/// Whether bodies that penetrate deeper than their contact points reach are searched again along the curve where the
/// surfaces cross. Also removes what only seems to overlap.
DeeperSearch begin_deeper(const PairFrame& frame, const PolygonSums& sums, const PairContact& contact,
                          std::uint32_t looked_at, bool meshes, PointList& points);
/// One row of at most 24 pairs of triangles; false when there are no more. Adds to `points`; allocates nothing.
bool look_deeper(const PlacedSurface& on_a, const PlacedSurface& on_b, const PolygonSums& sums, DeeperSearch& search,
                 PointList& points);

/// The manifold of a pair, from the contact points of its triangles and from its impact contact: that is the only point
/// where no others were found. Adds to `points`.
ManifoldPoints manifold_points_of(const PairFrame& frame, const Mat3& rotation_a, const PairContact& contact,
                                  std::uint32_t looked_at, PointList& points);

}  // namespace poise::collision
