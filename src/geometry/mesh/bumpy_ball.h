// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "poise/mesh.h"

namespace poise::geometry {

/// A closed mesh about 1 m across: a ball with rounded horns and dents, the same surface however finely it is cut. It
/// has the smallest number 20 n^2 of triangles that is at least `triangles` (1 to 20,000,000): an icosahedron with each
/// face cut into n^2, projected onto the ball and moved along the radius. For measuring how cost grows with triangles.
/// Refused: a count out of range.
Result<TriangleMesh> bumpy_ball(std::size_t triangles);

}  // namespace poise::geometry
