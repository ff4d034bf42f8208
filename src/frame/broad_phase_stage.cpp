// SPDX-License-Identifier: MIT
#include "frame/broad_phase_stage.h"

#include "parallel/ranges.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kVisitedGrain = 512;

// Puts into the grid of what rests what has come to rest, and takes out what moves.
void follow_changes(const BroadPhaseInput& input, BroadPhaseState& state, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const std::vector<std::uint32_t>& visited = input.motion.visited;
  parallel::select(
      executor, visited.size(), kVisitedGrain, state.counts,
      [&](std::size_t k) { return state.resting.holds(visited[k]); },
      [&](std::size_t count) { state.taken.resize(count); },
      [&](std::size_t k, std::size_t position) { state.taken[position] = visited[k]; });
  parallel::select(
      executor, visited.size(), kVisitedGrain, state.counts,
      [&](std::size_t k) {
        const std::uint32_t i = visited[k];
        return bodies.alive[i] != 0 && !bodies.moves(i) && !input.motion.body_bounds[i].plane;
      },
      [&](std::size_t count) { state.put.resize(count); },
      [&](std::size_t k, std::size_t position) {
        state.put[position] = motion_bound_of(input.scene, input.motion, visited[k]);
      });
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
