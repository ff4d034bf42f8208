// SPDX-License-Identifier: MIT
#pragma once

#include "studies/study_times.h"

namespace poise::app {

/// The command line of `poise study population`.
struct StudyPopulationOptions {
  StudyTimesOptions common;
  std::vector<std::uint64_t> bodies;  ///< empty: 1,000 to 100,000
  std::string clock;                  ///< `wall` (or empty) or `work`
  std::string hold = "both";          ///< `on`, `off` or `both`
  std::optional<std::uint64_t> budget_work, reference_every, reference_most_bodies;
  bool sleeping = false;
  bool here = false;  ///< measure the first population in this process: what the study starts its children with
};
void add_study_population_options(CLI::App& command, StudyPopulationOptions& options);

/// Measures what a deadline leaves of a scene as its population grows, each one in a process of its own.
int study_population(const StudyPopulationOptions& options);

/// The columns of its table, and one row of it.
std::vector<io::StudyColumn> population_columns();
std::vector<io::StudyCell> population_row(const StudyRun& run, const StudyRunCost& cost,
                                          const std::vector<simulation::RunFrame>& frames);
/// Whether frames are so late that a larger population is not tried: the median one by more than twelve deadlines.
bool too_late(double p50_ms, double deadline_ms);

}  // namespace poise::app
