// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "poise/mesh.h"

namespace poise::geometry {

/// Integrals over the signed tetrahedra between the triangles and a point near the mesh, for any mesh. For a closed
/// mesh they are volume, centre of mass and inertia. Centre and inertia are 0 if the volume is 0.
MassProperties mesh_volume(const TriangleMesh& mesh);

/// Sum of the triangles' areas.
double mesh_area_m2(const TriangleMesh& mesh);

/// Why a mesh cannot be used, as one line: no triangle, an index, a coordinate or its size out of range. Empty for a
/// usable mesh.
std::string why_unusable(const TriangleMesh& mesh);

/// Why so many threads cannot be used, as one line; empty if they can. 0 stands for as many as the machine has.
std::string why_not_threads(int threads);

/// Why a mesh does not enclose a volume, as one line with the count of open edges; empty for one that does.
std::string why_not_closed(const TriangleMesh& mesh);

}  // namespace poise::geometry
