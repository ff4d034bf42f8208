// SPDX-License-Identifier: MIT
#pragma once

#include "studies/error_time_run.h"
#include "studies/study_times.h"

namespace poise::app {

/// The command line of `poise study error-time`.
struct StudyErrorTimeOptions {
  StudyTimesOptions common;
  std::optional<std::uint64_t> bodies, states, every, history;
  std::vector<double> deadlines_ms;   ///< empty: 0.4 to 2
  std::vector<std::string> policies;  ///< empty: perceptual and random
  std::vector<int> iterations;        ///< of other engines; empty: 4 to 100
};
void add_study_error_time_options(CLI::App& command, StudyErrorTimeOptions& options);

/// Measures error against time. Returns the exit code.
int study_error_time(const StudyErrorTimeOptions& options);

/// The table of a run, a row a method; and its curves.
io::StudyTable error_time_table(const ErrorTimeRun& run, std::uint64_t seed);
std::vector<LineChart> error_time_charts(const io::StudyTable& table);

}  // namespace poise::app
