// SPDX-License-Identifier: MIT
#pragma once

#include "studies/study_times.h"

namespace poise::app {

/// The command line of `poise study crowd`.
struct StudyCrowdOptions {
  StudyTimesOptions common;
  std::optional<std::uint64_t> bodies, seeds, every;
};
void add_study_crowd_options(CLI::App& command, StudyCrowdOptions& options);

/// Measures how far the steps of a crowd are from their references at each level, how much of that comes from contacts
/// and how much from the response, and how much a small error of the contacts does. Returns the exit code.
int study_crowd(const StudyCrowdOptions& options);

}  // namespace poise::app
