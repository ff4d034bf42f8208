// SPDX-License-Identifier: MIT
#include <cmath>

#include "poise/scheduler/rival_policies.h"

namespace poise::scheduler {

// What the error of the completed level looks like to the viewer, in radians, whatever removing it costs.
double size_score(const Turn& turn) {
  if (turn.chain.level >= turn.chain.error_m.size()) return 0;
  const double angle_rad = turn.cues.angle_radpm * static_cast<double>(turn.chain.error_m[turn.chain.level]);
  return angle_rad > 0 ? std::min(angle_rad, kMostScore) : 0;
}

}  // namespace poise::scheduler
