// SPDX-License-Identifier: MIT
#pragma once

#include "frame/refine/refine.h"

/// Recording what a step decides, and doing it again (poise/decisions.h).
namespace poise::simulation {

/// Notes what the step left out, once that is decided.
void log_degraded(const CompletedLevels& levels, const Degraded& degraded, DecisionLog& log);

/// Leaves out what was left out; then completes the levels that were decided and no other, on all threads, and tallies
/// them; says what pairs were worth if the input asks. False when a pair, level or substep that was decided is not
/// there or does not fit: what there is has been done.
bool refine_as_recorded(const RefineInput& input, std::span<collision::FrontPool> pools,
                        const scheduler::FrameFacts& facts, CompletedLevels& levels, FrameReport& report,
                        parallel::Executor& executor);

}  // namespace poise::simulation
