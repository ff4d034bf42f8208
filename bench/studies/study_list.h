// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares each study as a command of `poise study`. `exit_code` must outlive the parse.
void add_studies(CLI::App& command, int& exit_code);

}  // namespace poise::app
