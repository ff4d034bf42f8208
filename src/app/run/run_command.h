// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise run`; parsing it runs the scene and sets `exit_code`.
void add_run_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
