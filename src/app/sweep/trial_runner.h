// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/process/progress.h"
#include "parallel/interrupt.h"
#include "poise/result.h"
#include "sweep/trial.h"
#include "sweep/trial_store.h"

namespace poise::app {

/// How trials are run on this machine.
struct RunnerSettings {
  std::vector<int> processors;  ///< that may be used
  bool bind = true;             ///< each trial is bound to processors; otherwise one runs at a time
  bool share = false;           ///< trials that count work may share processors with each other
  std::size_t workers = 1;      ///< trials at the same time, at most
  std::string engine = "local";
};

/// What came of them.
struct RunnerResult {
  std::size_t done = 0, failed = 0, timed_out = 0;
  bool stopped = false;    ///< by a signal; what ran then is pending
  Status stored = Done{};  ///< the first result that could not be stored, which ends the work
};

/// The processors that this process may use, ascending.
std::vector<int> own_processors();
/// The name of this machine.
std::string host_name();

/// Tells on stderr of a trial that failed or was ended, with the end of its log.
void tell_failure(const sweep::Trial& trial, const sweep::Outcome& outcome, const sweep::TrialStore& store);

/// Runs the trials, each as a process `poise run` of its own, and stores what comes of each as soon as it is over. A
/// trial by the wall clock has its processors alone. Those that need more of them than there are are refused by the
/// caller. Returns when all are over, a signal asks for the end, or a result cannot be stored.
RunnerResult run_trials(const std::vector<sweep::Trial>& trials, const sweep::TrialStore& store,
                        const RunnerSettings& settings, const parallel::Interrupt& interrupt, Progress& progress);

}  // namespace poise::app
