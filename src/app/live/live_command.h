// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise live`; parsing it serves the scene until Ctrl-C and sets `exit_code`.
void add_live_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
