// SPDX-License-Identifier: MIT
#include "frame/budget/crowds.h"

#include <algorithm>
#include <limits>
#include <numbers>

namespace poise::simulation {

std::uint32_t CrowdedByVolume::most_partners(std::uint32_t slot) const {
  const Shape& shape = *bodies_.shape[slot];
  const double radius_m = shape.bounding_radius_m;
  const double ball_m3 = 4.0 / 3.0 * std::numbers::pi * radius_m * radius_m * radius_m;
  // Chosen: a body that fills a hundredth of its ball, as rods do that are twelve times as long as wide, has less than
  // 400 in reach of it in the densest heap.
  constexpr double kOfFilling = 4;
  constexpr double kMost = std::numeric_limits<std::uint16_t>::max();
  if (!(shape.volume_m3 > kOfFilling / kMost * ball_m3)) return static_cast<std::uint32_t>(kMost);
  return std::max(kLeast, static_cast<std::uint32_t>(kOfFilling * ball_m3 / shape.volume_m3));
}

}  // namespace poise::simulation
