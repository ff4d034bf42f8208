// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kOcclusion{
    "occlusion", &Policy::occlusion, "hidden behind other bodies or not", "chosen; E_seen uses the same 0.25",
    // A pair that is hidden now may come into view, so the factor is never zero.
    [](const Policy& policy, const PairCues& cues) { return cues.hidden ? policy.hidden_visibility : 1.0; }};

}  // namespace poise::scheduler::cues
