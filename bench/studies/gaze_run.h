// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "studies/gaze_figures.h"
#include "studies/overload_drive.h"

namespace poise::app {

/// How the gaze is tried on a scene.
struct GazeSettings {
  std::uint64_t bodies = 0;
  std::uint64_t settle = 0;    ///< frames before the first state
  std::uint64_t seeds = 1;     ///< runs, from the scene's seed on; >= 1
  std::uint64_t states = 1;    ///< of each run, >= 1
  std::uint64_t every = 1;     ///< frames from one state to the next, >= 1
  std::uint64_t jumps = 0;     ///< of the gaze in each run
  std::uint64_t hold = 30;     ///< frames from one jump to the next, > kBeforeFrames and kSettledFrom
  double budget_share = 0.25;  ///< of the work of full refinement, > 0
  Shake shake;
  scheduler::Policy policy;  ///< valid
};

/// What came of it.
struct GazeRun {
  std::vector<GazeState> states;
  std::vector<GazeJump> jumps;
  std::uint64_t not_converged = 0;  ///< states that are left out: the reference had not converged
  double full_units = 0;            ///< work of full refinement in a run without a limit, mean of a frame over the runs
  GazeCamera camera;                ///< of the first run
};

/// Each run settles without a limit, which says what full refinement costs, and goes on with a share of that. Its
/// states are those of a run without a gaze (weight of eccentricity 0), so that no point is known better than another;
/// each is stepped with the gaze at each point, and measured by one reference. Then the gaze jumps from left to right
/// and back. Budgets are counted work: the same arguments give the same bits. Refused: as DrivenScene, a policy that
/// the World refuses, a scene that has nothing to refine, and after Ctrl-C.
Result<GazeRun> run_gaze(const Scene& scene, const SceneRunOptions& options, const GazeSettings& settings,
                         const ShareSink& told, const parallel::Interrupt* interrupt = nullptr);

}  // namespace poise::app
