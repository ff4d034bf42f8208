// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kGap{
    "gap", &Policy::gap, "rad, visible angle of the separation or penetration",
    "gaps are noticed (O'Sullivan and Dingliana 2001; O'Sullivan et al. 2003); the scale is chosen",
    [](const Policy& policy, const PairCues& cues) {
      return 1.0 + bounded(static_cast<double>(cues.gap_rad), kMostFactor) / policy.gap_scale_rad;
    }};

}  // namespace poise::scheduler::cues
