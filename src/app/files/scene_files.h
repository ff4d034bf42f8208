// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "poise/result.h"

namespace poise::app {

/// The scene files that ship, sorted by name: from beside an installed program, from the source, or from where it
/// was to be installed, the first of these that has any.
std::vector<std::filesystem::path> shipped_scenes();

/// The file that `scene` means: a name without folder and extension is a shipped scene, everything else a path.
/// Refused: a name that no shipped scene has.
Result<std::filesystem::path> find_scene(const std::string& scene);

}  // namespace poise::app
