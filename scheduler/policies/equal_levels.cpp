// SPDX-License-Identifier: MIT
#include "poise/scheduler/rival_policies.h"

namespace poise::scheduler {

// All pairs on one level before any goes deeper; on a level those first that have waited longest.
double equal_levels_score(const Turn& turn) {
  const double laps = laps_of(turn);
  const double place = 1.0 / (1.0 + static_cast<double>(turn.cues.frames_waited));
  return std::max(0.0, (laps - lap_of(turn) - place) / laps);
}

}  // namespace poise::scheduler
