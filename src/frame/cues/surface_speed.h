// SPDX-License-Identifier: MIT
#pragma once

#include "frame/cues/pair_place.h"

namespace poise::simulation {

/// Measures the cue *closing*: how fast the two surfaces approach each other where the pair meets, spin included, m/s
/// along the normal; negative where they part.
inline double surface_closing_mps(const PredictedMotion& motion, const ActivePair& pair, const PairPlace& place) {
  const auto surface_velocity = [&](std::uint32_t slot) -> Vec3 {
    const Vec3 arm_m = place.point_m - motion.poses[slot].position_m;
    return motion.body_bounds[slot].velocity_mps + motion.spins_radps[slot].cross(arm_m);
  };
  return place.normal.dot(surface_velocity(pair.a) - surface_velocity(pair.b));
}

}  // namespace poise::simulation
