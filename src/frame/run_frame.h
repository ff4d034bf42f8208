// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"

namespace poise::simulation {

/// One checked step: its stages in order, each given what it may read and change, and timed here and nowhere else. From
/// the thread that steps, or with `sliced` from that of sliced->task, by its clock. With `may_rest` bodies fall asleep
/// at its end; without, rest_after must follow.
FrameReport run_frame(WorldState& world, const StepInput& input, bool may_rest = true, SlicedStep* sliced = nullptr);

/// Lets bodies fall asleep, and islands wait, after a frame that was run without.
void rest_after(WorldState& world, const StepInput& input, FrameReport& report, SlicedStep* sliced = nullptr);

/// What *publish* and the list of contacts read of the last frame.
PublishInput publish_input(const WorldState& world);

}  // namespace poise::simulation
