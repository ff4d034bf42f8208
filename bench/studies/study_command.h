// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise study NAME`, the studies whose figures stand in the docs. `exit_code` must outlive the parse.
void add_study_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
