// SPDX-License-Identifier: MIT
#pragma once

#include "collision/broad_phase/broad_phase.h"
#include "frame/predict.h"
#include "world/candidate_cache.h"

/// Stage *broad_phase*: pairs of bodies whose motion bounds overlap.
namespace poise::simulation {

struct BroadPhaseInput {
  const PredictedMotion& motion;
  std::uint32_t max_partners = 0;  ///< candidates of one body at most
};

/// Output of *broad_phase*: sorted by (low, high), valid until the stage runs again with the same cache. May hold pairs
/// whose bounds do not overlap any more.
using CandidatePairs = collision::BroadPhase::Result;

/// Answers from `cache` while bodies stay inside its bounds.
inline void find_candidates(const BroadPhaseInput& input, collision::BroadPhase& broad_phase, CandidateCache& cache,
                            CandidatePairs& candidates, parallel::Executor& executor) {
  const PredictedMotion& motion = input.motion;
  candidates = cache.find(broad_phase, motion.bounds, motion.planes, motion.swept.bounds, input.max_partners, executor);
}

}  // namespace poise::simulation
