// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "app/sweep/sweep_options.h"
#include "app/sweep/sweep_plan.h"
#include "app/sweep/trial_runner.h"
#include "sweep/frontier.h"

namespace poise::app {

/// What `--dry-run` prints: scenes, axes, numbers of trials, the time that they need, and the first of them.
std::string plan_text(const SweepPlan& plan, const sweep::TrialStore& store, const std::vector<sweep::Trial>& pending,
                      const SweepOptions& options, const RunnerSettings& runner);

/// What is printed at the end: how many trials are in which state, and the frontier as a table; without one, in which
/// combinations the requirements do not hold.
std::string result_text(const sweep::SweepSpec& spec, const sweep::StateCounts& counts,
                        const std::vector<sweep::Group>& groups);

/// In how many of the combinations that were measured the requirements hold; empty where there are none.
std::string holds_text(const std::vector<sweep::Group>& groups);

/// The frontier as a Markdown table, a row for each line and a column for each value of the other axis; empty without
/// one. `>= 800`: the next larger value was not measured.
std::string frontier_table(const sweep::SweepSpec& spec, const std::vector<sweep::FrontierLine>& frontier);

}  // namespace poise::app
