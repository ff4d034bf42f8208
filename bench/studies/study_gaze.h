// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "studies/gaze_run.h"
#include "studies/study_times.h"

namespace poise::app {

/// The command line of `poise study gaze`.
struct StudyGazeOptions {
  StudyTimesOptions common;
  std::optional<std::uint64_t> bodies, settle, seeds, states, every, jumps, hold;
  std::optional<double> budget_percent, shake_mps;
  std::vector<std::string> weights;  ///< CUE=VALUE each
};
void add_study_gaze_options(CLI::App& command, StudyGazeOptions& options);

/// Measures whether what is looked at has less error than the same bodies when the gaze is elsewhere, and how soon
/// after a jump of the gaze. Returns the exit code.
int study_gaze(const StudyGazeOptions& options);

/// The tables of a run, its charts, and the script of its picture, which has maps too.
void add_gaze_tables(const GazeRun& run, std::uint64_t seed, io::StudyTable& table);
std::vector<LineChart> gaze_charts(const GazeRun& run);
std::string gaze_plot(const GazeRun& run, std::uint64_t seed);

}  // namespace poise::app
