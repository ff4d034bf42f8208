// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <string>
#include <vector>

#include "poise/result.h"
#include "sweep/sweep_spec.h"
#include "sweep/trial.h"
#include "sweep/trial_store.h"

namespace poise::app {

/// A specification with all its trials, each of which `poise run` would take.
struct SweepPlan {
  sweep::SweepSpec spec;
  std::vector<sweep::Trial> trials;
  /// What a scene says of the length of a run, as far as settings do not say otherwise; by the name of the scene.
  struct SceneTimes {
    double frames = 0, deadline_ms = 0;
  };
  std::map<std::string, SceneTimes> scenes;
};

/// What the result of a run depends on besides its scene and settings: version, commit, compiler and flags of this
/// program; of one that was built from changed or unknown sources its own bytes too.
Result<std::string> program_identity();

/// Reads a specification and expands it. `errors` gets every refusal, one line each: of the file, of scenes, of values
/// that `poise run` refuses, and of settings that contradict each other.
Result<SweepPlan> plan_sweep(const std::string& file, std::vector<std::string>& errors);

/// The trial as it is now: whether its scene and the files of its settings are what they were when `trial.key` was
/// made, and this program too. Refused: it has changed, or cannot be read.
Status check_unchanged(const sweep::Trial& trial, const std::string& identity);

/// How long the trials would take one after the other, and where that comes from.
struct TimeEstimate {
  double seconds = 0;
  std::string basis;  ///< e.g. `from 12 finished trials`
  bool known = false;
};
/// From the trials that have run, of the same scene where there are such; else from deadlines; else not known.
TimeEstimate estimate_time(const SweepPlan& plan, const sweep::TrialStore& store,
                           const std::vector<sweep::Trial>& pending);

}  // namespace poise::app
