// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kDelay{"delay", &Policy::delay, "s, for which approaching surfaces were not refined",
                           "delays are noticed (Michotte 1946; O'Sullivan and Dingliana 2001); the scale is chosen",
                           [](const Policy& policy, const PairCues& cues) {
                             return 1.0 +
                                    bounded(static_cast<double>(cues.delay_s), kMostFactor) / policy.delay_scale_s;
                           }};

}  // namespace poise::scheduler::cues
