// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kAttention{
    "attention", &Policy::attention, "where the host's attention is or not", "the host; the factor is chosen",
    [](const Policy& policy, const PairCues& cues) { return cues.attended ? policy.attention_factor : 1.0; }};

}  // namespace poise::scheduler::cues
