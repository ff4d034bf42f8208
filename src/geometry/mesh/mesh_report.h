// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "poise/mesh.h"

namespace poise::geometry {

/// Whether the samples of a mesh that is not closed show an enclosed volume; otherwise the mesh is a sheet.
bool encloses(const SampledMass& sampled);

/// The warning for the mass of such a mesh, as one line.
std::string open_note(const TriangleMesh& mesh, const SampledMass& sampled);

/// Why a mesh has no inside, as one line.
std::string nothing_inside(const TriangleMesh& mesh);

}  // namespace poise::geometry
