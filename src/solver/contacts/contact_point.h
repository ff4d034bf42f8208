// SPDX-License-Identifier: MIT
#pragma once

#include <hwy/base.h>

#include "collision/front/pair_frame.h"
#include "poise/types.h"

namespace poise::solver {

/// A cached contact point: a point on the surface of a and the plane that touches b opposite to it, fixed to the
/// bodies. For small motions the gap is n . (p_b - p_a) for any p_b on that plane, with an error of second order in the
/// rotation. One cache line, because pairs of a colour lie far apart in memory.
struct alignas(64) ContactPoint {
  Vec3 normal = Vec3::UnitZ();  ///< unit, from a to b, in the frame of b
  double plane_b_m = 0;         ///< n . p_b, in the frame of b
  Vec3 on_a_m = Vec3::Zero();   ///< in the frame of a
  double certainty_m = 0;       ///< the gap that is certain is larger by this, >= 0
};

/// Mean force of a contact point over the last substep, world frame: the warm start of the next step. A force and not
/// an impulse, because steps and substeps may have another length from frame to frame.
struct alignas(32) ContactForce {
  double normal_n = 0;             ///< along the normal, >= 0
  Vec3 friction_n = Vec3::Zero();  ///< across it
};

/// A contact point at the current poses, world frame.
struct PlacedPoint {
  Vec3 normal = Vec3::UnitZ();      ///< unit, from a to b
  Vec3 arm_m = Vec3::Zero();        ///< in the middle between the surfaces, from the centre of mass of a
  double gap_m = 0;                 ///< of the surfaces, negative in overlap
  double certain_separation_m = 0;  ///< >= gap_m; below zero they certainly penetrate there
};

/// Where two bodies push each other, as a share of the gap between their surfaces from a on: in the middle, the same
/// place for both; at the surface of the one that yields where the other does not. A pair is answered up to half a step
/// before or after it meets, and friction would take the gap for a part of the lever.
HWY_INLINE double share_of_gap(double inverse_mass_a, double inverse_mass_b) {
  if (inverse_mass_b == 0) return 0;
  return inverse_mass_a == 0 ? 1 : 0.5;
}

HWY_INLINE PlacedPoint placed_point(const collision::Pose& a, const collision::Pose& b, const ContactPoint& point) {
  PlacedPoint now;
  now.normal.noalias() = b.rotation * point.normal;
  const Vec3 arm_a = a.rotation * point.on_a_m;
  now.gap_m = now.normal.dot((b.position_m - a.position_m) - arm_a) + point.plane_b_m;
  now.arm_m = arm_a + (0.5 * now.gap_m) * now.normal;
  now.certain_separation_m = now.gap_m + point.certainty_m;
  return now;
}

}  // namespace poise::solver
