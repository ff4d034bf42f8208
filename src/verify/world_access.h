// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"
#include "poise/world.h"

namespace poise::simulation {

/// For tests and studies that read the inside of a World or replace a part of it.
struct WorldAccess {
  static WorldState& of(World& world) { return *world.state_; }
};

}  // namespace poise::simulation
