// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "frame/refine/refine.h"
#include "poise/trace.h"

namespace poise::simulation {

/// Adds the frame that has just ended, its stages and what each worker refined, from the times that the report and the
/// tallies hold: the frame itself does nothing for it. Under a deadline only do workers note times.
void trace_frame(std::span<const WorkerTally> tallies, const FrameReport& report, Trace& trace);

}  // namespace poise::simulation
