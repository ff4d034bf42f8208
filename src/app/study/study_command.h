// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise study`, for the list of commands alone; what follows it belongs to the program of the studies.
void add_study_command(CLI::App& app);

/// Becomes the program `poise-study` with the words that follow `poise study`: arguments, terminal, signals and exit
/// code are its own from here on. Returns only where there is no such program, having said how it is built, with
/// kExitBadUsage.
int start_study(int argc, char** argv);

}  // namespace poise::app
