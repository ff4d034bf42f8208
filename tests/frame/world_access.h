// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"
#include "poise/world.h"

namespace poise::simulation {

/// For tests that look inside a World or put something in its place.
struct WorldAccess {
  static WorldState& of(World& world) { return *world.state_; }
};

}  // namespace poise::simulation
