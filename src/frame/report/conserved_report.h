// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"

namespace poise::simulation {

/// Sums over the dynamic bodies as they are, on the threads of the World; the same bits on any number of them. The
/// thread that may call the World, between steps and slices.
Conserved conserved(const WorldState& world);

}  // namespace poise::simulation
