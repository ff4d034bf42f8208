// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include "frame/coarse.h"

namespace poise::simulation {

/// Measures the cue *gap*: by how much the surfaces of a pair are apart or overlap where it is answered as a contact,
/// metres, >= 0: by its cached points, or by its root spheres. 0 where it is not answered.
inline double answered_gap_m(const PredictedMotion& motion, const ActivePair& pair) {
  if (pair.cached->apart && pair.cached->reach_m > 0) return 0;
  const double separation_m =
      pair.cached->point_count > 0 ? pair.cached->nearest_m : coarsest_separation_m(motion, pair);
  return separation_m < pair.margin_m ? std::abs(separation_m) : 0.0;
}

}  // namespace poise::simulation
