// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

namespace poise::scheduler::cues {

constinit const Cue kWaiting{
    "waiting", &Policy::waiting, "frames since the pair was last refined", "chosen; nothing starves",
    [](const Policy&, const PairCues& cues) { return 1.0 + static_cast<double>(cues.frames_waited); }};

}  // namespace poise::scheduler::cues
