// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise shape`, which makes the small meshes that ship with the scenes. `exit_code` must outlive the parse.
void add_shape_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
