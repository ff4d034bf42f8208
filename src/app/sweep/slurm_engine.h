// SPDX-License-Identifier: MIT
#pragma once

#include <set>
#include <string>
#include <vector>

#include "app/process/progress.h"
#include "app/sweep/slurm_jobs.h"
#include "app/sweep/sweep_options.h"
#include "app/sweep/sweep_plan.h"
#include "parallel/interrupt.h"
#include "poise/result.h"
#include "sweep/trial_store.h"

namespace poise::app {

/// The arrays of a sweep that Slurm has not ended, and the keys of their trials.
struct ActiveArrays {
  std::vector<SubmittedArray> arrays;
  std::set<std::string> keys;
};

/// Asks Slurm (squeue) which arrays of the folder are not over. Where it does not answer, an array counts as active.
ActiveArrays active_arrays(const sweep::TrialStore& store);

/// Submits the trials by sbatch, one array for each number of cores, and adds them to `active`. Refused: sbatch is
/// missing or refuses, as it says; what cannot be written.
Status submit_arrays(const SweepPlan& plan, const std::vector<sweep::Trial>& pending, const sweep::TrialStore& store,
                     const SweepOptions& options, ActiveArrays& active);

/// Waits until no array is active, and tells of trials that fail meanwhile. Returns whether a signal ended the wait;
/// the arrays go on then.
bool wait_for_arrays(const SweepPlan& plan, const std::vector<sweep::Trial>& pending, const sweep::TrialStore& store,
                     const ActiveArrays& active, const parallel::Interrupt& interrupt, Progress& progress);

/// One task of an array: runs its trials, but those that have a result, and stores what comes of them. Returns the exit
/// code.
int run_slurm_task(const SweepOptions& options);

}  // namespace poise::app
