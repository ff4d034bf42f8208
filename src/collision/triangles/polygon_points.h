// SPDX-License-Identifier: MIT
#pragma once

#include "collision/front/pair_frame.h"
#include "collision/front/pair_refinement.h"
#include "collision/triangles/point_list.h"
#include "collision/triangles/polygon_sums.h"
#include "collision/triangles/triangle_pair.h"

namespace poise::collision {

/// Places nearer than this count for a pair whose surfaces are `least_m` apart, or overlap (<= 0); at most the frame's
/// margin.
double points_reach_m(const PairFrame& frame, double least_m);
/// Features count as passed through each other up to this depth while triangles are looked through.
double points_beneath_m(const PairFrame& frame);

/// Notes the features of the triangles `order` (of a in the high half, of b in the low one) as a place.
void note_point(const FacingFeatures& feature, std::uint64_t order, PointList& points);

/// Where a pair rests, from the places that its triangles gave and from what answers its impact. Bodies that overlap
/// deeper than these reach are looked at again along the curve where they cross; where nothing can be told the impact's
/// answer is the one place. Bounded: at most 24 x 24 triangles; allocates nothing. Adds to `places`.
ManifoldPoints manifold_points_of(const PairFrame& frame, const Mat3& rotation_a, const PlacedSurface& on_a,
                                  const PlacedSurface& on_b, const PolygonSums& sums, const PairContact& contact,
                                  PointList& points);

}  // namespace poise::collision
