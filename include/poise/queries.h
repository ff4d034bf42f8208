// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>

#include "poise/types.h"

/// Queries of a World: World::cast_ray, cast_sphere, overlap_sphere, overlap_box and closest_point. They use true
/// surfaces, not sphere trees: the triangles of a mesh, the spheres that a body is made of, planes. All vectors are
/// in the world frame, in metres.
///
/// A *solid* holds its inside: balls, half-spaces and closed meshes are solids. An open mesh, or one that was made as a
/// shell, is its surface alone.
///
/// Threads: between steps any number of threads may ask one World at once, as long as no thread steps or changes it.
/// The first query after a step or a change brings the index of bodies up to date (linear in the bodies) while others
/// wait; each further one takes time logarithmic in bodies and triangles. A World that is never asked has no index.
namespace poise {

/// Which bodies a query sees, by the rule for pairs: (group & body.collides_with) and (collides_with & body.group)
/// must both have a bit.
struct QueryFilter {
  std::uint32_t group = 0xffffffffU;          ///< bits: the groups that the query is in
  std::uint32_t collides_with = 0xffffffffU;  ///< bits: the groups that it sees
  BodyId ignore{};                            ///< this body is not seen, such as the one that asks; by default none
};

/// A ray from `origin_m` along `direction`.
struct Ray {
  Vec3 origin_m = Vec3::Zero();                                     ///< each component within 1e12 m of 0
  Vec3 direction = Vec3::UnitX();                                   ///< of any length but 0, finite
  double max_distance_m = std::numeric_limits<double>::infinity();  ///< >= 0
  /// The result for a solid in which the ray starts. False: a hit at distance 0, with the normal against the direction.
  /// True: the point where the ray first leaves it.
  bool leaves_solids = false;
};

/// The first point of a ray on a body.
struct RayHit {
  BodyId body;
  Vec3 point_m = Vec3::Zero();
  /// Unit, away from the inside of a solid; of a surface without inside, toward the origin of the ray.
  Vec3 normal = Vec3::UnitZ();
  double distance_m = 0;  ///< along the ray, in [0, max_distance_m]
};

/// A sphere that moves from `center_m` along `direction`.
struct SphereCast {
  Vec3 center_m = Vec3::Zero();                                     ///< each component within 1e12 m of 0
  double radius_m = 0;                                              ///< in [0, 1e12]; 0 is a ray
  Vec3 direction = Vec3::UnitX();                                   ///< of any length but 0, finite
  double max_distance_m = std::numeric_limits<double>::infinity();  ///< >= 0
};

/// The first touch of a moving sphere.
struct SphereCastHit {
  BodyId body;
  Vec3 point_m = Vec3::Zero();  ///< on the surface of the body
  Vec3 normal = Vec3::UnitZ();  ///< unit, from the body to the sphere
  double distance_m = 0;        ///< that the sphere has moved, in [0, max_distance_m]
  double fraction = 0;          ///< distance_m / max_distance_m; 0 where that is infinite or 0
  /// The sphere overlaps the body before it moves: distance 0; point and normal are those of the nearest point.
  bool overlaps_at_start = false;
};

/// A box of any orientation.
struct OrientedBox {
  Vec3 center_m = Vec3::Zero();               ///< each component within 1e12 m of 0
  Vec3 half_extents_m = Vec3::Constant(0.5);  ///< along its own axes, each in [0, 1e12]
  Quat orientation = Quat::Identity();        ///< box to world; normalised; not 0
};

/// The point of a body's surface that is nearest to another point.
struct ClosestPoint {
  BodyId body;
  Vec3 point_m = Vec3::Zero();
  /// Unit, the direction in which distance_m grows: away from the inside of a solid, of a surface without inside toward
  /// the point that asked.
  Vec3 normal = Vec3::UnitZ();
  /// From the surface to the point that asked, negative inside a solid. Inside a body of several balls the nearest
  /// point is that of the ball in which it lies deepest, even where another ball covers it: the way out is then longer.
  double distance_m = 0;
};

}  // namespace poise
