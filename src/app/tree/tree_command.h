// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise tree`, which builds and measures the sphere tree of a mesh. `exit_code` must outlive the parse.
void add_tree_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
