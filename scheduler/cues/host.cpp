// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kHost{
    "host", &Policy::host, "factor of the host", "the host",
    [](const Policy&, const PairCues& cues) { return bounded(static_cast<double>(cues.host), kMostHostFactor); }};

}  // namespace poise::scheduler::cues
