// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "math/functions.h"
#include "poise/types.h"

namespace poise::geometry {

/// Unit directions, uniformly spread by the golden angle (Fibonacci spiral); each represents the same area.
inline std::vector<Vec3> even_directions(int count) {
  std::vector<Vec3> directions;
  directions.reserve(static_cast<std::size_t>(count));
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count;
    const double r = std::sqrt(1 - z * z);
    directions.emplace_back(r * math::cos(golden_angle * i), r * math::sin(golden_angle * i), z);
  }
  return directions;
}

}  // namespace poise::geometry
