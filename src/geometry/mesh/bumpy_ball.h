// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "poise/mesh.h"

namespace poise::geometry {

/// A closed mesh about 1 m across: a ball with rounded horns and dents. The surface is the same for any number of
/// triangles. The mesh has the smallest number 20 n^2 of triangles that is at least `triangles` (1 to 20,000,000): an
/// icosahedron with each face divided into n^2, projected onto the ball and displaced along the radius. For measuring
/// how cost grows with the number of triangles. Refused: a count out of range.
Result<TriangleMesh> bumpy_ball(std::size_t triangles);

}  // namespace poise::geometry
