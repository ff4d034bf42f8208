// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "geometry/bvh/triangle_bvh.h"
#include "poise/sphere_tree.h"

namespace poise::geometry {

/// A ball that is part of an object (its surface included), such that the object is as far from the point that was
/// asked for as the ball is: a point of the surface with radius 0, or a ball about the point itself where that is
/// inside.
struct ObjectBall {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;
  std::uint32_t piece =
      TriangleBvh::kNoTriangle;  ///< the convex piece of the object that the answer comes from, if it has any
};

/// An object as the protrusion of spheres sees it. Called from any thread.
struct ObjectQueries {
  /// `guess` is a piece that may be near, or kNoTriangle; it changes the time only.
  std::function<ObjectBall(const Vec3& point, std::uint32_t guess)> nearest;
  /// Distance in metres to one convex piece of the object. Asked for the pieces that `nearest` names.
  std::function<double(std::uint32_t piece, const Vec3& point)> to_piece;
};

/// How far the exposed part of one sphere stands out of an object.
struct SphereProtrusion {
  double max_m = 0;   ///< no exposed point stands out farther
  double mean_m = 0;  ///< the area-weighted mean over the exposed part is not above this
};

/// Bounds the protrusion of the part of `own` that is not strictly inside one of `others`. The sphere is cut into
/// spherical triangles, and those that matter into four each, until both bounds are near what was seen: the largest
/// within 2 % or `tolerance_m`, the mean within some 5 % or half of `tolerance_m` (not proved, docs/sphere-trees.md).
/// Both are 0 where nothing is exposed. Deterministic. Any thread.
SphereProtrusion sphere_protrusion(const Sphere& own, std::span<const Sphere> others, const ObjectQueries& object,
                                   double tolerance_m);

}  // namespace poise::geometry
