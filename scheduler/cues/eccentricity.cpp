// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kEccentricity{
    "eccentricity", &Policy::eccentricity, "rad, between gaze and pair",
    "the threshold of acuity rises linearly (Strasburger, Rentschler and Juettner 2011)",
    [](const Policy& policy, const PairCues& cues) {
      return 1.0 / (1.0 + bounded(cues.eccentricity_rad, kMostFactor) / policy.eccentricity_e2_rad);
    }};

}  // namespace poise::scheduler::cues
