// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kHysteresis{"hysteresis", &Policy::hysteresis, "levels up to that of the frame before, or beyond",
                                "chosen; a level that changes to and fro is seen",
                                // It differs from level to level, so it is a factor of the gain (scheduler/gain.cpp).
                                nullptr};

}  // namespace poise::scheduler::cues
