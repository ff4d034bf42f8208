// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "peers/engine.h"

namespace poise::bench {

/// The quality of a pile, by one measure for every engine.
struct PileFigures {
  bool finite = true;             ///< all numbers are finite; if false, the other figures are undefined
  double mean_height_m = 0;       ///< of the centres of mass over z = 0
  double mean_speed_mps = 0;      ///< of the centres of mass
  double greatest_speed_mps = 0;  ///< of a centre of mass
  double greatest_overlap_m = 0;  ///< of two spheres of different bodies, or of a sphere and a wall; 0 if none
  double mean_overlap_m = 0;      ///< of the overlaps; 0 if none
  std::size_t overlaps = 0;       ///< number of overlaps
  std::size_t outside = 0;        ///< centres of mass behind a wall or the floor

  /// Whether the speed of the pile may be compared: all finite, no body outside, and no overlap above `most_overlap_m`.
  [[nodiscard]] bool holds(double most_overlap_m) const {
    return finite && outside == 0 && greatest_overlap_m <= most_overlap_m;
  }
};

/// Computes the figures from all neighbouring spheres: exact, about linear in their number. Any thread.
PileFigures pile_figures(const PileScene& scene, std::span<const BodyState> states);

}  // namespace poise::bench
