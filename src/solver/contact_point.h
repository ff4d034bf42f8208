// SPDX-License-Identifier: MIT
#pragma once

#include "collision/front/pair_frame.h"
#include "poise/types.h"

namespace poise::solver {

/// A place of contact as a pair keeps it: a point of each surface and the direction between them, fixed to the bodies.
/// While both move little, the gap there is n . (p_b - p_a) to second order in what they turn.
struct ContactPoint {
  Vec3 normal = Vec3::UnitZ();  ///< unit, from a to b, in the frame of b
  Vec3 on_a_m = Vec3::Zero();   ///< in the frame of a
  Vec3 on_b_m = Vec3::Zero();   ///< in the frame of b
  double certainty_m = 0;       ///< the gap that is certain is larger by this, >= 0
};

/// What a place bore in the last substep, world frame: what the next step starts from.
struct AccumulatedImpulse {
  double impulse_ns = 0;            ///< along the normal, >= 0
  Vec3 friction_ns = Vec3::Zero();  ///< across it
};

/// A place where it is now, world frame.
struct PlacedPoint {
  Vec3 normal = Vec3::UnitZ();      ///< unit, from a to b
  Vec3 arm_m = Vec3::Zero();        ///< in the middle between the surfaces, from the centre of mass of a
  double gap_m = 0;                 ///< of the surfaces, negative in overlap
  double certain_separation_m = 0;  ///< >= gap_m; below zero they overlap there beyond doubt
};

inline PlacedPoint placed_point(const collision::Pose& a, const collision::Pose& b, const ContactPoint& place) {
  PlacedPoint now;
  now.normal = b.rotation * place.normal;
  const Vec3 arm_a = a.rotation * place.on_a_m;
  now.gap_m = now.normal.dot((b.position_m - a.position_m) + (b.rotation * place.on_b_m - arm_a));
  now.arm_m = arm_a + (0.5 * now.gap_m) * now.normal;
  now.certain_separation_m = now.gap_m + place.certainty_m;
  return now;
}

}  // namespace poise::solver
