// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "poise/types.h"

namespace poise::collision {

/// The smallest convex parts of a surface: a ball (one corner) or a triangle (three corners, radius 0).
struct ConvexPart {
  std::array<Vec3, 3> corner_m{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  std::size_t corners = 1;  ///< 1 or 3
  double radius_m = 0;      ///< of a ball

  [[nodiscard]] std::span<const Vec3> all() const { return std::span(corner_m).first(corners); }
};

/// How near two convex parts are. Lengths in metres.
struct ConvexGap {
  double gap_m = 0;  ///< of two balls, or of a ball and a triangle, negative in overlap; of two triangles >= 0
  Vec3 normal = Vec3::Zero();   ///< unit, from a to b; zero where the parts meet and no direction can be told
  Vec3 point_m = Vec3::Zero();  ///< in the middle between the two nearest points
};

/// The nearest points of two parts, both in one frame: of two triangles the best of corner to face and side to side
/// (Ericson, "Real-Time Collision Detection", 2005, 5.1), 0 where one passes through the other. Any thread, allocates
/// nothing.
ConvexGap gap_of(const ConvexPart& a, const ConvexPart& b);

/// The same of a part and the half-space normal . x <= height_m; the normal unit, negative gaps in overlap.
ConvexGap gap_to_plane(const ConvexPart& a, const Vec3& normal, double height_m);

}  // namespace poise::collision
