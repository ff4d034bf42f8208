// SPDX-License-Identifier: MIT
#pragma once

#include "collision/front/pair_frame.h"
#include "collision/front/pair_refinement.h"
#include "collision/triangles/point_list.h"
#include "collision/triangles/polygon_sums.h"
#include "collision/triangles/triangle_pair.h"

namespace poise::collision {

/// Contact points nearer than this count for a pair whose surfaces are `least_m` apart, or overlap (<= 0); at most the
/// frame's margin.
double points_reach_m(const PairFrame& frame, double least_m);
/// Features count as passed through each other up to this depth while triangles are looked through.
double points_beneath_m(const PairFrame& frame);

/// Adds facing features as a contact point; `order` holds the triangle of a in its high half and that of b in its low
/// half.
void add_facing_point(const FacingFeatures& feature, std::uint64_t order, PointList& points);

/// The manifold of a pair, from the contact points of its triangles and from its impact contact. Bodies that penetrate
/// deeper than these points reach are searched again along the curve where the surfaces cross; where that finds nothing
/// the impact contact is the only point. Bounded: at most 24 x 24 triangles; allocates nothing. Adds to `points`.
ManifoldPoints manifold_points_of(const PairFrame& frame, const Mat3& rotation_a, const PlacedSurface& on_a,
                                  const PlacedSurface& on_b, const PolygonSums& sums, const PairContact& contact,
                                  PointList& points);

}  // namespace poise::collision
