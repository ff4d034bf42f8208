// SPDX-License-Identifier: MIT
#pragma once

#include "frame/ccd/swept_state.h"
#include "frame/integrate.h"

/// What kinematic bodies do in a frame: they move by their own velocities, whatever they meet.
namespace poise::simulation {

/// A moving kinematic body after a step: x + h v, and the exact rotation by h w. Any thread.
MovedBody moved_by_itself(const dynamics::BodyStore& bodies, std::size_t slot, double dt_s);

/// The way of a moving kinematic body through the step: nothing stops it, and what meets it is hit with its velocity.
void drive_trajectory(const dynamics::BodyStore& bodies, std::uint32_t slot, double dt_s, Trajectory& trajectory);

}  // namespace poise::simulation
