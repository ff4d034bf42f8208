// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "frame/refine/refine.h"
#include "parallel/shared_counters.h"
#include "poise/scheduler/frame_budget.h"
#include "poise/scheduler/policy.h"

namespace poise::simulation {

/// What the workers of a refinement under a deadline read and write before they publish a level. It belongs to the
/// World, not to the frame: a worker that the system holds up in the middle of a job is not waited for
/// (parallel::Executor::run_with), and may still read this, the outputs of *predict* and *coarse*, the shapes and the
/// fronts when the solver has long begun. It settles before the next step.
struct OpenRefinement {
  /// One job of one worker: the best that there is, if the forecast lets it begin. False: nothing more for this worker.
  bool operator()(int worker);
  class Job;

  /// One refinement: all that it reads, and what it publishes into.
  struct Run {
    RefineInput input;
    std::span<collision::FrontPool> pools;
    scheduler::PriorityBands& bands;
    CompletedLevels& levels;
    parallel::Executor& executor;
    scheduler::FrameFacts facts;
    scheduler::FrameBudget budget;
    double solved_share = 1;     ///< of the pairs not found separated
    DecisionLog* log = nullptr;  ///< of a step that is recorded
  };
  /// What a job has found out of a pair, and the level that is being worked out; it becomes the pair's when the job
  /// commits.
  struct alignas(64) Hand {
    PairProgress progress;
    collision::LevelContact found;
    collision::PairLevel level;
    collision::LevelContact next;
  };
  std::optional<Run> run;
  parallel::Shared<std::int64_t> contacts{0};  ///< pairs not found separated
  parallel::Shared<int> cut{0};                ///< not 0: the time is up for a job that was next
  std::vector<Hand> hands;                     ///< one a worker
  std::vector<std::uint32_t> chunks;           // scratch: of pairs that are ranked
};

}  // namespace poise::simulation
