// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string_view>

#include "poise/result.h"

namespace poise::app {

/// The file `name` in the folder of the program that runs: `poise` and `poise-study` are built and installed beside
/// each other. It need not exist. Refused: the system does not say which program runs.
Result<std::filesystem::path> program_beside(std::string_view name);

}  // namespace poise::app
