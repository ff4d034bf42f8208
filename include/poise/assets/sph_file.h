// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "poise/result.h"
#include "poise/sphere_tree.h"

namespace poise {

/// Reads the text format `.sph` of Bradshaw and O'Sullivan's toolkit, in metres. The first line is `levels branch`,
/// then follow rows `x y z r occupancy`; the children of row N are at N*B+1.. and a negative radius marks an unused
/// row. Lines after the last row are ignored. A node whose only descendants are copies of itself becomes a leaf. The
/// format has no protrusions; they are 0. Any thread. Refused with line and rule.
Result<SphereTree> read_sph(const std::filesystem::path& file);

/// Writes the same format. A leaf above the deepest level is repeated as its own only child, so that every level is
/// complete. Writes a temporary file and renames it: the file appears complete or not at all. Any thread.
Status write_sph(const SphereTree& tree, const std::filesystem::path& file);

}  // namespace poise
