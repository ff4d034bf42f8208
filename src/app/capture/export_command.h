// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise export`; when it is chosen, runs it and sets the exit code.
void add_export_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
