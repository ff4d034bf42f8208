// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "capture/capture.h"

namespace poise::capture {

/// Triangles to draw a shape with, in the frame of the body.
struct DrawnMesh {
  std::vector<std::array<float, 3>> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise from outside
};

/// The triangles of the shape; balls, and unions of them, as geodesic balls with their vertices on them; a plane as a
/// square of half side `reach_m` about the point that is nearest to the origin.
DrawnMesh drawn_mesh(const CapturedShape& shape, double reach_m);

}  // namespace poise::capture
