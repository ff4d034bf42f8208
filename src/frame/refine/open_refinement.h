// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "collision/front/pair_refinement.h"
#include "frame/refine/decision_log.h"
#include "parallel/shared_counters.h"
#include "poise/scheduler/frame_budget.h"
#include "poise/scheduler/policy.h"

namespace poise::simulation {

struct WorldState;

/// What the workers of a refinement under a deadline read and write before they publish a level. It belongs to the
/// World, not to the frame: a worker that the system holds up in the middle of a job is not waited for
/// (parallel::Executor::run_with), and may still read this, the shapes and the fronts when the response has long begun.
/// It settles before the next step.
struct OpenRefinement {
  /// One job of one worker: the best that there is, if the forecast lets it begin. False: nothing more for this worker.
  bool operator()(int worker);

  struct alignas(64) Hand {
    collision::PairLevel level;  ///< being worked out; these become the pair's when the job commits
    collision::LevelContact found;
  };
  WorldState* world = nullptr;
  scheduler::FrameFacts facts;
  scheduler::FrameBudget budget;
  double solved_share = 1;                     ///< of the pairs not found apart
  DecisionLog* log = nullptr;                  ///< of a step that is recorded
  parallel::Shared<std::int64_t> contacts{0};  ///< pairs not found apart
  parallel::Shared<int> cut{0};                ///< not 0: the time is up for a job that was next
  std::vector<Hand> hands;                     ///< one a worker
};

}  // namespace poise::simulation
