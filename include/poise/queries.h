// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>

#include "poise/types.h"

/// Queries of a World: World::cast_ray, cast_sphere, overlap_sphere, overlap_box and closest_point. They use the true
/// surfaces, not the sphere trees: triangles of meshes, balls of sphere unions, planes. All vectors are in the world
/// frame, in metres.
///
/// A *solid* includes its inside: balls, half-spaces and closed meshes are solids. An open mesh, and one that was made
/// as a shell, consists of its surface alone.
///
/// Threads: between steps any number of threads may query one World at once, as long as no thread steps or changes it.
/// The first query after a step or a change updates the index of bodies (linear in the bodies) while other queries
/// wait. Each further query takes time logarithmic in bodies and triangles. A World that is never queried builds no
/// index.
namespace poise {

/// Which bodies a query finds, by the rule for pairs: both (group & body.collides_with) and (collides_with &
/// body.group) must have a bit set.
struct QueryFilter {
  std::uint32_t group = 0xffffffffU;          ///< bits: the groups that the query is in
  std::uint32_t collides_with = 0xffffffffU;  ///< bits: the groups that it finds
  BodyId ignore{};                            ///< this body is never found, e.g. the one that asks; by default none
};

/// A ray from `origin_m` along `direction`.
struct Ray {
  Vec3 origin_m = Vec3::Zero();                                     ///< each component within 1e12 m of 0
  Vec3 direction = Vec3::UnitX();                                   ///< of any length but 0, finite
  double max_distance_m = std::numeric_limits<double>::infinity();  ///< >= 0
  /// Selects the result for a solid that contains the origin. False: a hit at distance 0 with the normal against the
  /// direction. True: the point where the ray first leaves the solid.
  bool leaves_solids = false;
};

/// The first point of a ray on a body.
struct RayHit {
  BodyId body;
  Vec3 point_m = Vec3::Zero();
  /// Unit. Points away from the inside of a solid; for a surface without inside, toward the origin of the ray.
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
  double distance_m = 0;        ///< travelled by the sphere, in [0, max_distance_m]
  double fraction = 0;          ///< distance_m / max_distance_m; 0 where that is infinite or 0
  /// The sphere overlaps the body at its start: distance_m is 0, point_m and normal are those of the nearest point.
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
  /// Unit, the direction in which distance_m grows: away from the inside of a solid; for a surface without inside,
  /// toward the query point.
  Vec3 normal = Vec3::UnitZ();
  /// From the surface to the query point, negative inside a solid. Inside a union of balls the result is on the ball in
  /// which the query point lies deepest, even if another ball covers that surface point; the distance out of the union
  /// is then longer.
  double distance_m = 0;
};

}  // namespace poise
