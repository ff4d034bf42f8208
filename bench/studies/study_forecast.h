// SPDX-License-Identifier: MIT
#pragma once

#include "studies/study_times.h"

namespace poise::app {

/// The command line of `poise study forecast`.
struct StudyForecastOptions {
  StudyTimesOptions common;
  std::vector<std::uint64_t> bodies;  ///< empty: 100 and 2000
  std::vector<double> alphas;         ///< empty: 0.01 and 0.001
  bool undisturbed = false;           ///< skip frames in which the system did not run the thread for part of the time
};
void add_study_forecast_options(CLI::App& command, StudyForecastOptions& options);

/// Compares the tail forecast with simpler methods on recorded frames.
int study_forecast(const StudyForecastOptions& options);

/// The command line of `poise study constant-time`.
struct StudyConstantTimeOptions {
  StudyTimesOptions common;
  std::optional<std::uint64_t> most_bodies;
};
void add_study_constant_time_options(CLI::App& command, StudyConstantTimeOptions& options);

/// Measures how the time of a frame grows with the number of bodies, with and without a deadline.
int study_constant_time(const StudyConstantTimeOptions& options);

}  // namespace poise::app
