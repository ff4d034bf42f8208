// SPDX-License-Identifier: MIT
#include <cmath>

#include "poise/scheduler/rival_policies.h"

namespace poise::scheduler {
namespace {

constexpr double kGroups = 3;
constexpr double kGoldenShare = 0.6180339887498949;

// What is near the gaze, what else is in the frustum, and what is outside it. Chosen: O'Sullivan and Dingliana leave
// the groups to the application.
double group_of(const Turn& turn) {
  if (!(turn.cues.visibility >= 1)) return 2;
  return turn.cues.eccentricity_rad <= 2 * turn.policy.eccentricity_e2_rad ? 0 : 1;
}

}  // namespace

// Groups of priority, and in a group a level of each pair before the next of any (O'Sullivan and Dingliana 1999). The
// queue begins at another pair in each frame, so that all have their turn where there is time for a few.
double round_robin_score(const Turn& turn) {
  const double begun = kGoldenShare * static_cast<double>(turn.frame.frame % 1000000);
  const double place = place_of(turn) + begun;
  const double laps = laps_of(turn);
  const double in_group = std::max(0.0, (laps - lap_of(turn) - (place - std::floor(place))) / laps);
  return (kGroups - 1 - group_of(turn) + in_group) / kGroups;
}

}  // namespace poise::scheduler
