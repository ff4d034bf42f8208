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

/// A ball that is part of an object (its surface included), such that the distance from a query point to the object is
/// that to the ball: a surface point with radius 0, or for a query point inside a ball about that point.
struct ObjectBall {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;
  /// The convex piece of the object that contains the result, if there is one.
  std::uint32_t piece = TriangleBvh::kNoTriangle;
};

/// Distance queries on an object, for the protrusion of spheres. Called from any thread.
struct ObjectQueries {
  /// The nearest part of the object. `guess` is a piece that may be near, or kNoTriangle; it affects only the time.
  std::function<ObjectBall(const Vec3& point, std::uint32_t guess)> nearest;
  /// Distance in metres to one convex piece of the object. Called for pieces that `nearest` returned.
  std::function<double(std::uint32_t piece, const Vec3& point)> to_piece;
};

/// Bounds of the distance by which the exposed part of one sphere protrudes from an object, metres.
struct SphereProtrusion {
  double max_m = 0;   ///< no exposed point protrudes farther
  double mean_m = 0;  ///< upper bound of the area-weighted mean over the exposed part
};

/// Bounds the protrusion of the part of `own` that is not strictly inside one of `others`. The sphere is cut into
/// spherical triangles; those that affect the bounds are subdivided until both bounds are near the sampled values: the
/// largest within 2 % or `tolerance_m`, the mean within about 5 % or half of `tolerance_m` (not proved,
/// docs/sphere-trees.md). Both are 0 if nothing is exposed. Deterministic. Any thread.
SphereProtrusion sphere_protrusion(const Sphere& own, std::span<const Sphere> others, const ObjectQueries& object,
                                   double tolerance_m);

}  // namespace poise::geometry
