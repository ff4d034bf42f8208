// SPDX-License-Identifier: MIT
#pragma once

#include "capture/capture.h"

namespace poise::capture {

/// A body's place and turn.
struct Pose {
  Vec3 position_m = Vec3::Zero();
  Quat orientation = Quat::Identity();
};

/// The nearest pose that a capture can hold. Coordinates beyond kMostSteps steps stay at that distance. `orientation`
/// must be about unit.
PackedPose pack(const Pose& pose, double position_step_m, std::uint32_t orientation_steps);
/// A coordinate in steps, within kMostSteps.
std::int64_t pack_coordinate(double metres, double step_m);

/// The pose that was packed, to half a step in each coordinate and orientation_error_rad of angle. Unit.
Pose unpack(const PackedPose& pose, double position_step_m, std::uint32_t orientation_steps);

/// Bound of the angle between an orientation and what pack and unpack make of it.
///
/// A component k / S is wrong by 1 / (2 S), so the three by sqrt(3) / (2 S) together. The largest is at least 1/2 and
/// the others together at most sqrt(3)/2, so its error is at most sqrt(3) times as large, and that of the quaternion
/// twice; an angle is twice the distance of quaternions, to first order. 1 % is added for higher orders.
double orientation_error_rad(std::uint32_t orientation_steps);

/// |k| of a sound pose.
inline bool sound(const PackedPose& pose, std::uint32_t orientation_steps) {
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    if (pose.position[axis] < -kMostSteps || pose.position[axis] > kMostSteps) return false;
    const std::int64_t k = pose.orientation[axis];
    if (k < -std::int64_t{orientation_steps} || k > std::int64_t{orientation_steps}) return false;
  }
  return pose.largest < 4;
}

}  // namespace poise::capture
