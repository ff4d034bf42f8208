// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kFrustum{"frustum", &Policy::frustum, "1 inside the view, outside_frustum outside",
                             "chosen; hidden motion comes back into view",
                             // Never zero, and so is the measured visibility.
                             [](const Policy&, const PairCues& cues) { return bounded(cues.visibility, 1.0); }};

}  // namespace poise::scheduler::cues
