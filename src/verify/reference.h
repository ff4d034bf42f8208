// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"
#include "poise/reference.h"

/// The reference of a frame (docs/method.md). It belongs to World::step, which calls remember before a frame and refer
/// after it, both outside of the frame's time, and nothing of it in a step that does not ask for one.
namespace poise::simulation {

/// Copies the state that the frame is about to start from.
void remember(const WorldState& world, Reference& reference);

/// Does the frame that has just ended again from the remembered state, with data of its own and the predicted motion of
/// the run, and says how far apart the two are. Uses the World's threads and `pools`, one a worker, which it clears;
/// the result does not depend on the threads.
ReferenceFigures refer(const WorldState& world, const StepInput& input, std::span<collision::FrontPool> pools,
                       Reference& reference);

}  // namespace poise::simulation
