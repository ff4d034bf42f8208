// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kOnset{
    "onset", &Policy::onset, "s, since the contact began",
    "causality is seen when a contact begins (Michotte 1946); the form is chosen",
    // 2 when a contact begins, 1 when it is old.
    [](const Policy& policy, const PairCues& cues) {
      return 1.0 + 1.0 / (1.0 + bounded(static_cast<double>(cues.age_s), kMostFactor) / policy.onset_scale_s);
    }};

}  // namespace poise::scheduler::cues
