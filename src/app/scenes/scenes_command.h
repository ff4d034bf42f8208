// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise scenes`, which lists the scenes that ship.
void add_scenes_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
