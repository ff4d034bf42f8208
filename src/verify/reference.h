// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"
#include "poise/reference.h"

/// The reference of a frame (docs/method.md). It belongs to World::step, which calls remember before a frame and refer
/// after it, both outside of the frame's time, and nothing of it in a step that does not ask for one.
namespace poise::simulation {

/// Keeps the state that the frame is about to start from.
void remember(WorldState& world);

/// Does the frame that has just ended again from the remembered state, and says how far apart the two are. Uses the
/// World's threads; the result does not depend on them.
ReferenceFigures refer(WorldState& world, const StepInput& input);

}  // namespace poise::simulation
