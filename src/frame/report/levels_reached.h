// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"

namespace poise::simulation {

/// How deep the step that has just ended got, for StepInput::measure_levels.
LevelsReached levels_reached(const WorldState& world, const View& view);

}  // namespace poise::simulation
