// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"

/// What is left out of a frame whose mandatory part does not fit before its deadline, in this order: substeps of
/// resting contact; then pairs answer as they did last, the least seen first. Sweeps beyond one a substep are no part
/// of it: visits_in_time (frame_time.h) stops them. Called by World::step alone, from its thread.
namespace poise::simulation {

/// How many pairs must be reused to save `late`, if a pair that stays apart saves `apart_ns` and one that keeps its
/// places `places_ns` (both
/// >= 0); at most as many as there are. Lists them in buffers.least_seen, which must have room for all pairs.
std::size_t pairs_to_reuse(WorldState& world, Nanoseconds late, double apart_ns, double places_ns);

/// Leaves out what `degraded` says. What it does depends on the state, the cues and its two numbers alone, so a replay
/// of the numbers gives the same bits. Pairs that are reused are those whose memory is too old to be sure of, by the
/// weight of their cues, ties in canonical order; they keep their places, or stay apart, only while no gap can have
/// changed by more than the radius of the smaller body. Called after the pairs are found and before refinement;
/// restore() must follow.
void degrade(WorldState& world, const Degraded& degraded);

/// The same as it was decided in another run of this step, the pairs by name, and what that was. False where a pair
/// cannot be reused or there are not so many substeps: another step than that one.
bool degrade_as_recorded(WorldState& world, const FrameDecisions& decisions, Degraded& degraded);

/// After the frame is published: what is kept means again what it does with all substeps.
void restore(WorldState& world);

}  // namespace poise::simulation
