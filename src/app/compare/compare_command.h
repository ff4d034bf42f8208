// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Adds `poise compare`; it sets the exit code when it was the command.
void add_compare_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
