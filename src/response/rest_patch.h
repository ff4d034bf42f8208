// SPDX-License-Identifier: MIT
#pragma once

#include "poise/types.h"

namespace poise::response {

/// One place where a pair rests, world frame.
struct RestPatch {
  Vec3 normal = Vec3::UnitZ();        ///< unit, from a to b
  Vec3 arm_m = Vec3::Zero();          ///< of the place, from the centre of mass of a
  double gap_m = 0;                   ///< of the surfaces there at the start of the step, negative in overlap
  double surely_m = 0;                ///< below zero they overlap there beyond doubt
  double impulse_ns = 0;              ///< along the normal in a substep, >= 0: what the last step ended with goes in, what this one ends with comes out
  Vec3 friction_ns = Vec3::Zero();    ///< across it, likewise
};

}  // namespace poise::response
