// SPDX-License-Identifier: MIT
#pragma once

#include "frame/cues/crowd_map.h"
#include "frame/cues/occlusion.h"

namespace poise::simulation {

struct RefineInput;

/// What the cues of all pairs of a step share. Made before the first of them is asked for, and only what the policy
/// asks for.
struct PreparedCues {
  Occlusion occlusion;
  CrowdMap crowd;
  bool crowd_counted = false;

  /// Those of the last step are not those of this one.
  void forget() { occlusion.found = crowd_counted = false; }
};

/// After forget().
void prepare_cues(const RefineInput& input, PreparedCues& prepared, parallel::Executor& executor);

}  // namespace poise::simulation
