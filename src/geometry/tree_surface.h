// SPDX-License-Identifier: MIT
#pragma once

#include "geometry/triangle_bvh.h"
#include "parallel/executor.h"
#include "poise/sphere_tree.h"

namespace poise::geometry {

/// A flat piece of a surface.
struct SurfacePiece {
  double area_m2 = 0;
  Vec3 moment_m3 = Vec3::Zero();  ///< integral of the position from the ball's centre over the piece
};

/// The part of a triangle inside a ball, in closed form: the disc that the ball cuts from the triangle's plane, met with
/// the triangle edge by edge, as triangles to the disc's centre where an edge is inside and sectors where it is not. `normal` is the
/// triangle's unit normal.
SurfacePiece triangle_in_ball(const TriangleCorners& t, const Vec3& normal, const Sphere& ball);

/// Fills tree.surface: the area of the mesh inside each node's sphere, the area-weighted mean of its normals, and the place of its
/// centroid along that mean normal. Exact but for the rounding to the stored sizes. A mean normal that rounds to 0, as that of
/// a whole closed surface, has offset 0. The result does not depend on the executor.
void measure_surfaces(SphereTree& tree, const TriangleBvh& bvh, parallel::Executor& executor);

}  // namespace poise::geometry
