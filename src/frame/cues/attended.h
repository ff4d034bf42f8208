// SPDX-License-Identifier: MIT
#pragma once

#include "dynamics/body_store.h"
#include "frame/coarse.h"

namespace poise::simulation {

/// Measures the cue *attention*: whether the host's attention is on a pair that meets at a point.
inline bool is_attended(const Attention& attention, const dynamics::BodyStore& bodies, const ActivePair& pair,
                        const Vec3& point_m) {
  if (bodies.contains(attention.body) && (attention.body.slot == pair.a || attention.body.slot == pair.b)) return true;
  return attention.radius_m > 0 &&
         (point_m - attention.center_m).squaredNorm() <= attention.radius_m * attention.radius_m;
}

}  // namespace poise::simulation
