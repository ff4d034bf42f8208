// SPDX-License-Identifier: MIT
#include "frame/broad_phase_stage.h"

#include "parallel/ranges.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kVisitedGrain = 512;

// What is in the grid of what rests and moves or was changed.
void list_taken(const BroadPhaseInput& input, BroadPhaseState& state, parallel::Executor& executor) {
  state.taken.clear();
  if (state.resting.size() == 0) return;
  const std::vector<std::uint32_t>& visited = input.motion.visited;
  parallel::select(
      executor, visited.size(), kVisitedGrain, state.counts,
      [&](std::size_t k) { return state.resting.holds(visited[k]); },
      [&](std::size_t count) { state.taken.resize(count); },
      [&](std::size_t k, std::size_t position) { state.taken[position] = visited[k]; });
}

// What rests and was changed.
void list_put(const BroadPhaseInput& input, BroadPhaseState& state, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const std::vector<std::uint32_t>& visited = input.motion.visited;
  state.put.clear();
  // All that is dynamic is visited.
  if (visited.size() == bodies.dynamic_count()) return;
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
}

// Puts into the grid of what rests what has come to rest, and takes out what moves.
void follow_changes(const BroadPhaseInput& input, BroadPhaseState& state, parallel::Executor& executor) {
  list_taken(input, state, executor);
  list_put(input, state, executor);
  if (!state.put.empty()) state.resting.reserve(input.scene.bodies.slot_count());
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
