// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "math/double_double.h"

namespace poise::math {

/// Steps in a full turn.
inline constexpr std::uint32_t kStepsOfTurn = 1024;

/// An angle as a whole number of steps of a turn and a rest of at most half a step.
struct ReducedAngle {
  std::uint32_t steps = 0;  ///< below kStepsOfTurn
  DoubleDouble rest_rad;
};

/// angle_rad, finite, less whole turns. The rest has a relative error below 2^-70 unless angle_rad is within 2^-40 of a
/// multiple of a step; its absolute error is below 2^-113.
ReducedAngle reduced(double angle_rad);

}  // namespace poise::math
