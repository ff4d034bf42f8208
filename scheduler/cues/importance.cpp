// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kImportance{
    "importance", &Policy::importance, "factor of the scene", "the scene",
    [](const Policy&, const PairCues& cues) { return bounded(static_cast<double>(cues.importance), kMostFactor); }};

}  // namespace poise::scheduler::cues
