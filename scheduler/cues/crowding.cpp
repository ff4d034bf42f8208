// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kCrowding{"crowding", &Policy::crowding, "other events near by on the screen",
                              "what is crowded is recognised worse (Bouma 1970); the form is chosen",
                              [](const Policy& policy, const PairCues& cues) {
                                return 1.0 / (1.0 + static_cast<double>(cues.crowd) / policy.crowding_scale);
                              }};

}  // namespace poise::scheduler::cues
