// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise tune`, for the list of commands alone; what follows it belongs to the program of the search.
void add_tune_command(CLI::App& app);

/// Becomes the search (src/app/tune, a program in Python) with the words that follow `poise tune`: terminal, signals
/// and exit code are its own from here on. Python is that of POISE_PYTHON, else the system's own, which sees the
/// packages of the distribution, else the first on the path. Returns only where Python or the program is not there,
/// having said so, with kExitBadUsage.
int start_tune(int argc, char** argv);

}  // namespace poise::app
