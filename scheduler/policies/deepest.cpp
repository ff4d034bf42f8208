// SPDX-License-Identifier: MIT
#include "poise/scheduler/rival_policies.h"

namespace poise::scheduler {

// The pair that has come deepest goes on, in the order of the queue: a few pairs are refined to their end, the others
// not at all.
double deepest_score(const Turn& turn) {
  return std::max(0.0, (lap_of(turn) + 1 - place_of(turn)) / (laps_of(turn) + 1));
}

}  // namespace poise::scheduler
