// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Adds `poise view`, which makes the page of one capture, or of two on one clock.
void add_view_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
