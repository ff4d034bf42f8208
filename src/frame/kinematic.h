// SPDX-License-Identifier: MIT
#pragma once

#include "frame/ccd/swept_state.h"
#include "frame/integrate.h"

/// What kinematic bodies do in a frame: they move by their own velocities, whatever they meet.
namespace poise::simulation {

/// Moves a kinematic body through a step: x + h v, and the exact rotation by h w. One that stands keeps its bits.
/// Returns how far it moved. Any thread, each body by one.
StepMotion move_kinematic(dynamics::BodyStore& bodies, std::size_t slot, double dt_s);

/// The way of a moving kinematic body through the step: nothing stops it, and what meets it is hit with its velocity.
void drive_trajectory(const dynamics::BodyStore& bodies, std::uint32_t slot, double dt_s, Trajectory& trajectory);

}  // namespace poise::simulation
