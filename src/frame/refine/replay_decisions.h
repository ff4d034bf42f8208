// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"

/// Recording what a step decides, and doing it again (poise/decisions.h).
namespace poise::simulation {

/// The log of the step that is about to refine, with room for all that it can do.
DecisionLog& begin_log(WorldState& world, const scheduler::FrameFacts& facts);

/// Notes what the step left out, once that is decided.
void log_degraded(const WorldState& world, const Degraded& degraded, DecisionLog& log);

/// Leaves out what was left out; then completes the levels that were decided and no other, on all threads, and tallies
/// them; says what pairs were worth if the input asks. False when a pair, level or substep that was decided is not
/// there or has no room: what there is has been done.
bool refine_as_recorded(WorldState& world, const StepInput& input, const scheduler::FrameFacts& facts,
                        FrameReport& report);

}  // namespace poise::simulation
