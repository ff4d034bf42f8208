// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include "geometry/bvh/triangle_bvh_build.h"
#include "poise/types.h"

/// Rays, moving spheres and boxes against single triangles and balls, in double. Any thread; nothing allocates.
namespace poise::query {

inline constexpr double kMiss = std::numeric_limits<double>::infinity();

/// A ray with what its tests against triangles have in common.
///
/// Watertight: two triangles that share an edge leave no gap between them and a ray through the edge hits one of them
/// (Woop, Benthin, Wald, "Watertight ray/triangle intersection", JCGT 2013), since each edge gives both triangles
/// numbers of opposite sign and equal size.
class TriangleRay {
 public:
  /// `direction` unit.
  TriangleRay(const Vec3& origin_m, const Vec3& direction);
  /// Distance along the ray to the triangle, >= 0; kMiss where it does not meet it. A ray in the triangle's plane meets
  /// nothing.
  [[nodiscard]] double distance_m(const geometry::TriangleCorners& t) const;

 private:
  Vec3 origin_m_;
  Eigen::Index x_, y_, z_;  ///< axes, the third the one along which the ray runs most
  double shear_x_, shear_y_, shear_z_;
};

/// Where a ray enters and leaves a ball, as distances along it that may be negative; both kMiss where it passes by. By
/// the point of nearest approach, so that a far origin costs no digits (Haines et al., "Precision improvements for
/// ray/sphere intersection", Ray Tracing Gems, 2019, chapter 7).
struct BallCrossing {
  double enters_m = kMiss, leaves_m = kMiss;
};
BallCrossing crossing_of_ball(const Vec3& origin_m, const Vec3& direction, const Vec3& center_m, double radius_m);

/// How far a sphere moves along a unit direction until it touches a triangle; kMiss where it does not. It must not
/// overlap the triangle before it moves. The ray of its centre against the triangle grown by the radius: two faces,
/// three cylinders, three balls. Triangles without area count as their edges.
double sphere_to_triangle_m(const Vec3& center_m, double radius_m, const Vec3& direction,
                            const geometry::TriangleCorners& t);

/// Does a triangle meet the box |x| <= half_extents_m, borders included? By the 13 axes that can separate them
/// (Akenine-Möller, "Fast 3D triangle-box overlap testing", 2001).
bool triangle_meets_box(const geometry::TriangleCorners& t, const Vec3& half_extents_m);

/// Unit normal by the order of the corners; 0 without area.
Vec3 normal_of(const geometry::TriangleCorners& t);

}  // namespace poise::query
