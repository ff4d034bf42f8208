// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise check`, which says what is wrong with a scene, what it needs, and what looks wrong.
void add_check_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
