// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "app/picture/body_raster.h"
#include "app/picture/drawn_frame.h"

namespace poise::io {

/// A plane of the scene as it is drawn, world frame: normal . x = offset_m, the normal to the side where bodies are.
struct DrawnPlane {
  Vec3 normal = Vec3::UnitZ();
  double offset_m = 0;
  bool ground = true;         ///< without an end, chequered; else a low wall
  std::vector<Vec3> corners;  ///< walls: the part that is drawn, convex
};

/// The planes of a frame. What is level or a slope is ground. A steep one is a wall: it is drawn where the other planes
/// leave it, up to a tenth of its length, so that it hides nothing; one without an end on both sides is not drawn.
std::vector<DrawnPlane> drawn_planes(const DrawnFrame& frame, std::span<const capture::CapturedShape> shapes);

/// Where a ray from the eye first meets the side of a plane where bodies are: the distance in lengths of `ray`, world
/// frame. None if it does not, or beside the drawn part.
std::optional<double> distance_along(const DrawnPlane& plane, const Vec3& from_m, const Vec3& ray);

}  // namespace poise::io
