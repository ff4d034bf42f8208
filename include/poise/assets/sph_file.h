// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "poise/result.h"
#include "poise/sphere_tree.h"

namespace poise {

/// Reads the text format `.sph` of Bradshaw and O'Sullivan's toolkit: first line `levels branch`, then rows
/// `x y z r occupancy`, children of N at N*B+1.., a negative radius for an unused place; lines after the last row are
/// ignored. A node below which there is nothing but itself ends there. Protrusions are not in the format and are 0.
/// Refused with line and rule.
Result<SphereTree> read_sph(const std::filesystem::path& file);

/// Writes the same format; a node that ends early is repeated down as its own only child, so that every level is whole.
/// Written to a temporary file and renamed.
Status write_sph(const SphereTree& tree, const std::filesystem::path& file);

}  // namespace poise
