// SPDX-License-Identifier: MIT
#include "poise/scheduler/rival_policies.h"

namespace poise::scheduler {

// Every level is one lap of the queue, and the first lap comes first.
double fifo_score(const Turn& turn) {
  const double laps = laps_of(turn);
  return std::max(0.0, (laps - lap_of(turn) - place_of(turn)) / laps);
}

}  // namespace poise::scheduler
