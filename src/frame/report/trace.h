// SPDX-License-Identifier: MIT
#pragma once

#include "frame/frame.h"
#include "poise/trace.h"

namespace poise::simulation {

/// Adds a frame of a step in slices, and its stages.
void trace_stages(const FrameReport& report, Trace& trace);
/// Adds the frame that has just ended, its stages, what each worker refined and its longest piece, from the times that
/// the report and the tallies hold: the frame itself does nothing for it. Under a deadline only do workers note times.
void trace_frame(const Frame& frame, const dynamics::BodyStore& bodies, const FrameReport& report, Trace& trace);

}  // namespace poise::simulation
