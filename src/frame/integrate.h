// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "frame/solve.h"

/// Stage *integrate*: positions and orientations after the step.
namespace poise::simulation {

/// How a body moved in a step.
struct StepMotion {
  Vec3 moved_m = Vec3::Zero();
  double turned_m = 0;  ///< at most by so much its surface moved by turning
};

/// Output of *integrate* beside the bodies: one a slot.
struct StepMotions {
  parallel::UnsetVector<StepMotion> of_slot;
};

/// Moves the bodies, and clears the forces that were applied for the step.
void integrate(const Velocities& velocities, double dt_s, dynamics::BodyStore& bodies, StepMotions& motions,
               parallel::Executor& executor);

}  // namespace poise::simulation
