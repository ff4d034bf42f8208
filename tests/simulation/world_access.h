// SPDX-License-Identifier: MIT
#pragma once

#include "poise/world.h"
#include "simulation/world_state.h"

namespace poise::simulation {

/// For tests that look inside a World or put something in its place.
struct WorldAccess {
  static WorldState& of(World& world) { return *world.state_; }
};

}  // namespace poise::simulation
