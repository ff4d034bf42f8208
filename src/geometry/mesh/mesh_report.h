// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "poise/mesh.h"

namespace poise::geometry {

/// Whether a mesh that is not closed holds something without doubt, measured by its samples; else it is a sheet.
bool encloses(const SampledMass& sampled);

/// The warning that goes with the mass of such a mesh, as one line.
std::string open_note(const TriangleMesh& mesh, const SampledMass& sampled);

/// Why a mesh has no inside, as one line.
std::string nothing_inside(const TriangleMesh& mesh);

}  // namespace poise::geometry
