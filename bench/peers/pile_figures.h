// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "peers/engine.h"

namespace poise::bench {

/// How a pile stands, by one measure for every engine.
struct PileFigures {
  bool finite = true;             ///< all numbers are; the others say nothing where not
  double mean_height_m = 0;       ///< of the centres of mass over z = 0
  double mean_speed_mps = 0;      ///< of the centres of mass
  double greatest_speed_mps = 0;  ///< of a centre of mass
  double greatest_overlap_m = 0;  ///< of two spheres of different bodies, or of a sphere and a wall; 0 if none
  double mean_overlap_m = 0;      ///< of the places that overlap; 0 if none
  std::size_t overlaps = 0;       ///< such places
  std::size_t outside = 0;        ///< centres of mass behind a wall or the floor

  /// The pile is one whose speed may be compared: all finite, nobody outside, and no overlap beyond `most_overlap_m`.
  [[nodiscard]] bool holds(double most_overlap_m) const {
    return finite && outside == 0 && greatest_overlap_m <= most_overlap_m;
  }
};

/// Looks at all spheres that are near each other: exact, about linear in their number. Any thread.
PileFigures pile_figures(const PileScene& scene, std::span<const BodyState> states);

}  // namespace poise::bench
