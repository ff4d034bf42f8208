// SPDX-License-Identifier: MIT
#pragma once

#include "frame/publish.h"

namespace poise::simulation {

/// The outputs of all stages of one frame. Each is written by its stage alone, and const for those after it. All stay
/// until the next frame: contacts and figures of the step are read from them.
struct Frame {
  PredictedMotion motion;
  CandidatePairs candidates;
  PairTable table;
  CompletedLevels levels;
  Manifolds manifolds;
  Velocities velocities;
  StepMotions motions;
  Publication publication;
};

}  // namespace poise::simulation
