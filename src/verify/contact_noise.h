// SPDX-License-Identifier: MIT
#pragma once

#include "frame/frame.h"

namespace poise::simulation {

/// Errors for contacts, to see how much depends on them: each separation gets a random number of its own, evenly spread
/// from -separation_m to separation_m; each component of a contact point one up to point_m; and each component of a
/// unit normal one up to normal_rad, before it is made unit again. All 0: none.
struct ContactNoise {
  double separation_m = 0;
  double point_m = 0;
  double normal_rad = 0;  ///< about the angle, since it is small
  [[nodiscard]] bool any() const { return separation_m > 0 || point_m > 0 || normal_rad > 0; }
};

/// Adds errors to what refinement has found of each pair: to the contact of impacts, and to each contact point of
/// resting contact. Contacts of level 0 stay. The numbers depend on the two bodies of a pair and on what was found.
void add_noise(const ContactNoise& noise, const PredictedMotion& motion, const PairTable& table,
               CompletedLevels& levels);

}  // namespace poise::simulation
