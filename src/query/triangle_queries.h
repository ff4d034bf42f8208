// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include "geometry/bvh/triangle_bvh_build.h"
#include "poise/types.h"

/// Tests of rays, moving spheres and boxes against single triangles and balls, in double. Any thread; nothing
/// allocates.
namespace poise::query {

inline constexpr double kMiss = std::numeric_limits<double>::infinity();

/// A ray with the data that its tests against triangles share.
///
/// Watertight: two triangles that share an edge leave no gap, and a ray through the edge hits one of them (Woop,
/// Benthin, Wald, "Watertight ray/triangle intersection", JCGT 2013), since each edge gives both triangles numbers of
/// opposite sign and equal size.
class TriangleRay {
 public:
  /// `direction` must be unit.
  TriangleRay(const Vec3& origin_m, const Vec3& direction);
  /// Distance along the ray to the triangle, >= 0; kMiss if the ray misses it. A ray in the triangle's plane hits
  /// nothing.
  [[nodiscard]] double distance_m(const geometry::TriangleCorners& t) const;

 private:
  Vec3 origin_m_;
  Eigen::Index x_, y_, z_;  ///< axes; the third is the one along which the ray advances most
  double shear_x_, shear_y_, shear_z_;
};

/// Distances along a ray at which it enters and leaves a ball; they may be negative, and both are kMiss if it misses
/// the ball. Computed from the point of nearest approach, so that a far origin loses no digits (Haines et al.,
/// "Precision improvements for ray/sphere intersection", Ray Tracing Gems, 2019, chapter 7).
struct BallCrossing {
  double enters_m = kMiss, leaves_m = kMiss;
};
BallCrossing crossing_of_ball(const Vec3& origin_m, const Vec3& direction, const Vec3& center_m, double radius_m);

/// Distance that a sphere moves along a unit direction until it touches a triangle; kMiss if it does not. It must not
/// overlap the triangle at the start. Casts a ray from its centre against the triangle enlarged by the radius: two
/// faces, three cylinders, three balls. A triangle without area is replaced by its edges.
double sphere_to_triangle_m(const Vec3& center_m, double radius_m, const Vec3& direction,
                            const geometry::TriangleCorners& t);

/// Whether a triangle meets the box |x| <= half_extents_m, borders included, by the 13 separating axes (Akenine-Möller,
/// "Fast 3D triangle-box overlap testing", 2001).
bool triangle_meets_box(const geometry::TriangleCorners& t, const Vec3& half_extents_m);

/// Unit normal by the order of the corners; 0 for a triangle without area.
Vec3 normal_of(const geometry::TriangleCorners& t);

}  // namespace poise::query
