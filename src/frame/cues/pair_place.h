// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "frame/coarse.h"

namespace poise::simulation {

/// Where a pair meets, as far as is known. Of a pair that is known by its root spheres alone: where the smaller one is
/// nearest to the other.
struct PairPlace {
  Vec3 point_m = Vec3::Zero();  ///< world frame
  Vec3 normal = Vec3::UnitZ();  ///< about unit, from a to b
};
inline PairPlace place_of(const PredictedMotion& motion, const ActivePair& pair) {
  const BodyBounds& a = motion.body_bounds[pair.a];
  const BodyBounds& b = motion.body_bounds[pair.b];
  PairPlace place;
  if (b.plane) {
    place.normal = -b.position_m;
    place.point_m = a.root_center_m + a.root_radius_m * place.normal;
    return place;
  }
  const Vec3 between = b.root_center_m - a.root_center_m;
  const double distance = between.norm();
  if (distance > 0) place.normal = between / distance;
  place.point_m = a.root_radius_m <= b.root_radius_m
                      ? Vec3(a.root_center_m + std::min(a.root_radius_m, distance) * place.normal)
                      : Vec3(b.root_center_m - std::min(b.root_radius_m, distance) * place.normal);
  return place;
}

/// The same of a pair whose points are cached: where the first of them is, that of the impact.
inline PairPlace place_of(const PredictedMotion& motion, const ActivePair& pair, const PointCache& points) {
  if (pair.cached->point_count == 0) return place_of(motion, pair);
  const solver::ContactPoint& point = points.points[PointCache::begin(pair.cached->slot)];
  const collision::Pose& a = motion.poses[pair.a];
  return {a.position_m + a.rotation * point.on_a_m, motion.poses[pair.b].rotation * point.normal};
}

}  // namespace poise::simulation
