// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "poise/types.h"

namespace poise::dynamics {

/// Orientation (principal frame to world, unit) and angular velocity (world, rad/s) of a rigid body.
struct Rotation {
  Quat orientation = Quat::Identity();
  Vec3 spin_radps = Vec3::Zero();
};

/// Rotates a body freely for `time_s`: no torque, principal moments `moments_kgm2` (all > 0).
///
/// Implicit midpoint in the body frame with the Cayley map for the orientation, in parts whose number depends on the
/// spin. Conserves energy and the angular momentum vector to rounding for any step (quadratic invariants of the
/// midpoint rule; the Cayley map of the same midpoint spin transports the momentum: e.g. Hairer, Lubich and Wanner,
/// Geometric Numerical Integration, VII.5). A body with equal moments is rotated by the exact exponential. Any thread.
Rotation turned_freely(const Rotation& start, const Vec3& moments_kgm2, double time_s);

/// What stays where a turn needs energy.
enum class TurnKeeps : std::uint8_t {
  Momentum,  ///< the angular momentum vector: the body is not turned
  Turn,      ///< the turn and the energy, of the momentum only its direction
};

/// Rotates a body by `turn` (world) without torque and time. The angular momentum vector is conserved, and the angular
/// velocity follows. Where that would need energy, `keeps` decides. Any thread.
Rotation turned_by(const Rotation& start, const Vec3& moments_kgm2, const Quat& turn, TurnKeeps keeps);

/// The rotation by a vector (axis times angle, rad) as a unit quaternion.
Quat rotation_by(const Vec3& angle_rad);

}  // namespace poise::dynamics
