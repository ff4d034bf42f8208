// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise job-array`, which no help shows: by it the search of `poise tune`, a program in Python, submits its
/// workers as `poise sweep` submits its trials. With --submit it submits a job array, whose tasks run the words of the
/// command with `--task NUMBER` behind them. Without, it prints the numbers of the arrays that were submitted in the
/// folder and are not over, a line each.
void add_job_array_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
