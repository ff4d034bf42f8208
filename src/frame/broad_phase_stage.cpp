// SPDX-License-Identifier: MIT
#include "frame/broad_phase_stage.h"

namespace poise::simulation {
namespace {

// Puts into the grid of what rests what has come to rest, and takes out what moves.
void follow_changes(const BroadPhaseInput& input, BroadPhaseState& state, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  state.taken.reserve(bodies.slot_count());
  state.put.reserve(bodies.slot_count());
  state.taken.clear();
  state.put.clear();
  for (const std::uint32_t i : input.motion.visited) {
    if (state.resting.holds(i)) state.taken.push_back(i);
    if (bodies.alive[i] != 0 && !bodies.moves(i) && !input.motion.body_bounds[i].plane)
      state.put.push_back(motion_bound_of(input.scene, input.motion, i));
  }
  if (!state.put.empty()) state.resting.reserve(bodies.slot_count());
  state.resting.change(state.taken, state.put, executor);
}

}  // namespace

void find_candidates(const BroadPhaseInput& input, BroadPhaseState& state, CandidatePairs& candidates,
                     parallel::Executor& executor) {
  const PredictedMotion& motion = input.motion;
  if (!motion.swept.on) {
    follow_changes(input, state, executor);
  } else if (state.resting.size() > 0) {
    state.resting.clear();
  }
  candidates = state.cache.find(state.of_moving, motion.bounds, motion.planes, motion.swept.bounds, state.resting,
                                input.limits, executor);
}

}  // namespace poise::simulation
