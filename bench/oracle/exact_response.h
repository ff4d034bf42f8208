// SPDX-License-Identifier: MIT
#pragma once

#include "oracle/free_flight.h"

namespace poise::oracle {

/// Velocity changes of one collision.
struct Answer {
  Vec3 dv_a_mps = Vec3::Zero();
  Vec3 dw_a_radps = Vec3::Zero();
  Vec3 dv_b_mps = Vec3::Zero();
  Vec3 dw_b_radps = Vec3::Zero();
  double approach_mps = 0;  ///< of the two points along the normal before the impulse, > 0 when they approach
};

/// One frictionless impulse along the true normal, midway between the nearest points (Dingliana and O'Sullivan 2000,
/// eq. 1-3). `restitution` in [0, 1]. All zero if the bodies do not touch or are separating. Any thread.
Answer exact_answer(const OracleMesh& a, const Flight& flight_a, const OracleMesh& b, const Flight& flight_b,
                    const FirstTouch& touch, double restitution);

}  // namespace poise::oracle
