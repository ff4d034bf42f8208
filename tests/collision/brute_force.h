// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/shapes.h"

namespace poise::collision {

/// Bounds of many sizes, groups and kinds; of slots 1, 4, 7, ...
inline std::vector<MotionBound> random_bounds(std::mt19937_64& random, std::size_t n, double spread_m, int octaves) {
  std::vector<MotionBound> bounds(n);
  for (std::size_t i = 0; i < n; ++i) {
    bounds[i].center_m = random_vector(random, spread_m);
    bounds[i].radius_m = std::exp2(uniform(random, -octaves, 0));
    bounds[i].slot = static_cast<std::uint32_t>(i * 3 + 1);
    bounds[i].dynamic = random() % 8 != 0;
    bounds[i].group = 1U << (random() % 3);
    bounds[i].collides_with = static_cast<std::uint32_t>(random() % 8);
  }
  return bounds;
}

/// What the broad phase has to find, by looking at all pairs.
inline std::vector<CandidatePair> brute_force(std::span<const MotionBound> bounds, std::span<const PlaneBound> planes) {
  std::vector<CandidatePair> pairs;
  const auto meets = [](const auto& a, const auto& b) {
    return (a.group & b.collides_with) != 0 && (b.group & a.collides_with) != 0;
  };
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    for (std::size_t j = i + 1; j < bounds.size(); ++j) {
      const double reach = bounds[i].radius_m + bounds[j].radius_m;
      if ((bounds[i].center_m - bounds[j].center_m).squaredNorm() >= reach * reach) continue;
      if (!bounds[i].dynamic && !bounds[j].dynamic) continue;
      if (!meets(bounds[i], bounds[j])) continue;
      pairs.push_back({std::min(bounds[i].slot, bounds[j].slot), std::max(bounds[i].slot, bounds[j].slot)});
    }
    for (const PlaneBound& plane : planes) {
      if (!bounds[i].dynamic || !meets(bounds[i], plane)) continue;
      if (plane.normal.dot(bounds[i].center_m) - plane.height_m >= bounds[i].radius_m) continue;
      pairs.push_back({std::min(bounds[i].slot, plane.slot), std::max(bounds[i].slot, plane.slot)});
    }
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const auto& x, const auto& y) { return std::pair(x.low, x.high) < std::pair(y.low, y.high); });
  return pairs;
}

}  // namespace poise::collision
