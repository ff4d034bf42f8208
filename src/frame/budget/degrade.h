// SPDX-License-Identifier: MIT
#pragma once

#include "frame/refine/refine.h"

/// What is left out of a frame whose mandatory part does not fit before its deadline although islands wait (hold.h), in
/// this order: substeps of the contact solver; then pairs reuse what is cached of them, the least seen first. Solver
/// iterations beyond one a substep are no part of it: iterations_in_time (frame_time.h) stops them. A hook of *refine*,
/// before its first level.
namespace poise::simulation {

/// The contact solver makes so many substeps in this frame; 0, or no fewer than the settings say: as they say.
void use_substeps(const RefineInput& input, int substeps, CompletedLevels& levels);

/// Chooses the pairs that must be reused to save `late`, if one that stays separated saves `apart_ns` and one that
/// keeps its cached points `points_ns` (both > 0), into levels.reused; how many they are, at most as many as there are.
/// These may be: pairs of which what is cached is too old to be sure of; they keep their points, or stay separated,
/// only while no separation can have changed by more than the radius of the smaller body. The least seen come first, to
/// a quarter of an octave (PairCueSource::seen); pairs that are seen alike in canonical order.
std::size_t choose_reused(const RefineInput& input, Nanoseconds late, double apart_ns, double points_ns,
                          CompletedLevels& levels, parallel::Executor& executor);

/// Leaves out what `degraded` says, and of pairs those of levels.reused.
void degrade(const RefineInput& input, const Degraded& degraded, CompletedLevels& levels, parallel::Executor& executor);

/// The same as it was decided in another run of this step, the pairs by name, and what that was. False where a pair
/// cannot be reused or there are not so many substeps: another step than that one.
bool degrade_as_recorded(const RefineInput& input, const FrameDecisions& decisions, CompletedLevels& levels,
                         Degraded& degraded);

}  // namespace poise::simulation
