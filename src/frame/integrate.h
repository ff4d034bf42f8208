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

/// A body after the step, as far as its numbers are in range.
struct MovedBody {
  BodyState state;
  StepMotion motion;
};

/// Output of *integrate* beside the bodies: one a slot.
struct StepMotions {
  parallel::UnsetVector<StepMotion> of_slot;
  std::vector<std::uint32_t> out_of_range;  ///< slots of bodies that the step would have taken there, ascending
};

struct IntegrateInput {
  const PredictedMotion& motion;
  const Velocities& velocities;
  double dt_s = 0;
};

/// Moves the bodies, and clears the forces that were applied for the step, and what was noted of changed bodies. A body
/// whose new state is not finite or beyond the limits of BodyState comes to rest where it was, and counts as changed.
void integrate(const IntegrateInput& input, dynamics::BodyStore& bodies, StepMotions& motions,
               parallel::Executor& executor);

}  // namespace poise::simulation
