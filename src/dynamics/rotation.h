// SPDX-License-Identifier: MIT
#pragma once

#include "poise/types.h"

namespace poise::dynamics {

/// Orientation (principal frame to world, unit) and angular velocity (world, rad/s) of a rigid body.
struct Rotation {
  Quat orientation = Quat::Identity();
  Vec3 spin_radps = Vec3::Zero();
};

/// Turns a body freely for `time_s`: no torque, principal moments `moments_kgm2` (all > 0).
///
/// Implicit midpoint in the body frame with the Cayley map for the orientation, in as many parts as the spin asks for.
/// It keeps energy and the angular momentum vector to rounding (quadratic invariants of the midpoint rule; the Cayley
/// map of the same midpoint spin carries the momentum along: e.g. Hairer, Lubich and Wanner, Geometric Numerical
/// Integration, VII.5), for any step. Equal moments turn by the exact exponential. Any thread.
Rotation turned_freely(const Rotation& start, const Vec3& moments_kgm2, double time_s);

/// Turns a body by `turn` (world) without a torque or time: the angular momentum vector stays, so the spin follows;
/// where that would take energy, the energy stays and the momentum only its direction.
Rotation turned_by(const Rotation& start, const Vec3& moments_kgm2, const Quat& turn);

/// The rotation by a vector (axis times angle, rad) as a unit quaternion.
Quat rotation_by(const Vec3& angle_rad);

}  // namespace poise::dynamics
