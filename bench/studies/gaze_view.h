// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <numbers>
#include <span>

#include "poise/step.h"

namespace poise::app {

inline constexpr double kGazeDegreeRad = std::numbers::pi / 180;

/// The three points that are looked at: left, centre, right.
inline constexpr std::size_t kGazePoints = 3;
inline constexpr std::array<const char*, kGazePoints> kGazeNames{"left", "centre", "right"};

/// Who looks at a heap, and where to.
struct GazeCamera {
  View view;                              ///< its gaze is at the centre point
  std::array<Vec3, kGazePoints> gazes{};  ///< unit, in the order of kGazeNames
};

/// The camera of the gaze study: vertical angle of view 30 degrees at 16:9 (51 degrees across, as a screen 60 cm wide
/// at 63 cm). It looks along y and down by 40 degrees at a box about `positions_m` (not empty), from where the box just
/// fits into the picture. A twentieth of the positions at each end of each axis is not in the box. The points are in
/// the middle of the box along y and z, and at 15, 50 and 85 % of its width along x.
GazeCamera overlooking(std::span<const Vec3> positions_m);

/// A place in the picture, in shares of its width from the left and of its height from the top.
struct ScreenPlace {
  double across = 0, down = 0;
  bool inside = false;  ///< false: beside the picture or behind the viewer; the shares may then be anything
};
ScreenPlace on_screen(const View& view, const Vec3& point_m);
/// The same view with the gaze at one of the points.
View gazing_at(const GazeCamera& camera, std::size_t gaze_point);

/// Angle between the gaze and a point, [0, pi].
double eccentricity_rad(const View& view, const Vec3& point_m);

}  // namespace poise::app
