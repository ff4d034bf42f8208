// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Adds `poise sweep`.
void add_sweep_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
