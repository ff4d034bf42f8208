// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kSize{"size", &Policy::size, "rad/m, visible angle of a metre of error", "geometry",
                          // The angle is a factor of the gain, whose unit needs it (scheduler/gain.cpp).
                          nullptr};

}  // namespace poise::scheduler::cues
