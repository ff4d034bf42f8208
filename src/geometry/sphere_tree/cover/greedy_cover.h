// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/sphere_tree/cover/cover_cells.h"
#include "geometry/sphere_tree/cover/deep_candidates.h"

namespace poise::geometry {

/// Limits of the work of a greedy cover.
struct GreedySettings {
  std::size_t cells = 2000;  ///< most cells that the cover uses, taken at equal intervals
  std::size_t points = 150;  ///< most points, likewise
  int halvings = 7;          ///< of the interval that holds the stand-off
  int random_starts = 4;     ///< further tries at each stand-off, with a random first ball
};

/// A cover of some cells by few balls.
struct GreedyCover {
  std::vector<DeepPoint> points;  ///< at most kTreeBranching
  float stand_off = 0;            ///< the balls have radius depth + stand_off
};

/// Finds the smallest stand-off s such that at most kTreeBranching of the balls (point, depth + s) contain all cells,
/// by bisection. At each s, balls are taken in the order of how many cells they add. Points farther than `radius` from
/// `center` are excluded; the middles of some cells are added as points. Deterministic. Any thread.
GreedyCover cover_greedily(const CoverCells& cells, const std::vector<std::uint32_t>& members,
                           const std::vector<DeepPoint>& points, const Vec3f& center, float radius,
                           const TriangleBvh& bvh, const CoverFrame& frame, std::uint64_t seed,
                           const GreedySettings& settings);

}  // namespace poise::geometry
