// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/broad_phase/resting_grid.h"
#include "frame/predict.h"
#include "world/candidate_cache.h"

/// Stage *broad_phase*: pairs of bodies whose motion bounds overlap.
namespace poise::simulation {

struct BroadPhaseInput {
  SceneView scene;
  const PredictedMotion& motion;
  collision::PartnerLimits limits;
};

/// What the stage keeps from step to step.
struct BroadPhaseState {
  collision::BroadPhase of_moving;
  collision::RestingGrid resting;
  CandidateCache cache;

  parallel::UnsetVector<std::uint32_t> taken;         // scratch: bodies that rest no more, or elsewhere
  parallel::UnsetVector<collision::MotionBound> put;  // scratch: bodies that rest now
  std::vector<std::size_t> counts;                    // scratch
};

/// Output of *broad_phase*: sorted by (low, high), valid until the stage runs again with the same state. May hold pairs
/// whose bounds do not overlap any more.
using CandidatePairs = collision::BroadPhase::Result;

/// Answers from the cache while bodies stay inside its bounds. Bodies that rest cost nothing while they do.
void find_candidates(const BroadPhaseInput& input, BroadPhaseState& state, CandidatePairs& candidates,
                     parallel::Executor& executor);

}  // namespace poise::simulation
