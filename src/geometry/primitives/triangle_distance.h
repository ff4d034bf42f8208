// SPDX-License-Identifier: MIT
#pragma once

#include "geometry/bvh/triangle_bvh_build.h"
#include "poise/types.h"

namespace poise::geometry {

/// Whether the segment meets the triangle, borders included, by the signs of the volumes that it spans with the edges
/// (Segura and Feito 2001), in double. A segment in the triangle's plane and a triangle without area meet nothing. Any
/// thread.
bool segment_meets_triangle(const Vec3& from, const Vec3& to, const TriangleCorners& t);

/// Least squared distance of two segments, m^2, either may be a point (Ericson, "Real-Time Collision Detection",
/// 2005, 5.1.9). Any thread.
double squared_distance_of_segments_m2(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s);

/// Least distance of two triangles in metres, 0 where they meet: the least of corner to face and edge to edge, unless
/// an edge of one passes through the other. Triangles without area count as their edges. Any thread.
double distance_of_triangles_m(const TriangleCorners& s, const TriangleCorners& t);

}  // namespace poise::geometry
