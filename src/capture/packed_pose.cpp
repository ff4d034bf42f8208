// SPDX-License-Identifier: MIT
#include "capture/packed_pose.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace poise::capture {

std::int64_t pack_coordinate(double metres, double step_m) {
  constexpr auto kMost = static_cast<double>(kMostSteps);
  return std::llround(std::clamp(metres / step_m, -kMost, kMost));
}

PackedPose pack(const Pose& pose, double position_step_m, std::uint32_t orientation_steps) {
  PackedPose packed;
  for (int axis = 0; axis < 3; ++axis)
    packed.position[static_cast<std::size_t>(axis)] = pack_coordinate(pose.position_m[axis], position_step_m);
  const Quat& q = pose.orientation;
  const std::array<double, 4> parts{q.w(), q.x(), q.y(), q.z()};
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (std::abs(parts[i]) > std::abs(parts[largest])) largest = i;
  }
  const double scale = (parts[largest] < 0 ? -1.0 : 1.0) * orientation_steps;
  std::size_t next = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const double most = orientation_steps;
    packed.orientation[next++] = static_cast<std::int32_t>(std::lround(std::clamp(parts[i] * scale, -most, most)));
  }
  packed.largest = static_cast<std::uint8_t>(largest);
  return packed;
}

Pose unpack(const PackedPose& packed, double position_step_m, std::uint32_t orientation_steps) {
  Pose pose;
  for (int axis = 0; axis < 3; ++axis) {
    pose.position_m[axis] = static_cast<double>(packed.position[static_cast<std::size_t>(axis)]) * position_step_m;
  }
  std::array<double, 4> parts{};
  double squares = 0;
  std::size_t next = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == packed.largest) continue;
    parts[i] = static_cast<double>(packed.orientation[next++]) / orientation_steps;
    squares += parts[i] * parts[i];
  }
  parts[packed.largest] = std::sqrt(std::max(0.0, 1.0 - squares));
  pose.orientation = Quat(parts[0], parts[1], parts[2], parts[3]).normalized();
  return pose;
}

double orientation_error_rad(std::uint32_t orientation_steps) {
  return 1.01 * 2 * std::numbers::sqrt3 / orientation_steps;
}

}  // namespace poise::capture
