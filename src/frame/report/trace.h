// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"

namespace poise::simulation {

/// Adds the frame that has just ended, its stages and what each worker refined, from the times that the report and the
/// tallies hold: the frame itself does nothing for it. Under a deadline only do workers note times.
void trace_frame(const WorldState& world, const FrameReport& report, Trace& trace);

}  // namespace poise::simulation
