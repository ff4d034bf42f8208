// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kClosing{"closing", &Policy::closing, "m/s, of the two surfaces at the contact point",
                             "chosen; fast events are noticed", [](const Policy& policy, const PairCues& cues) {
                               return 1.0 + bounded(cues.closing_mps, kMostFactor) / policy.closing_scale_mps;
                             }};

}  // namespace poise::scheduler::cues
