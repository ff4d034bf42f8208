// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/sphere_tree/cover/cover_cells.h"
#include "geometry/sphere_tree/cover/deep_candidates.h"

namespace poise::geometry {

/// How much work a greedy cover is worth.
struct GreedySettings {
  std::size_t cells = 2000;  ///< the cover looks at no more than these, evenly taken
  std::size_t points = 150;  ///< likewise
  int halvings = 7;          ///< of the interval that holds the stand-off
  int random_starts = 4;     ///< further tries at each stand-off, with a random first ball
};

/// A cover of some cells by few balls.
struct GreedyCover {
  std::vector<DeepPoint> points;  ///< at most kTreeBranching
  float stand_off = 0;            ///< the balls have radius depth + stand_off
};

/// Looks for the smallest stand-off s such that at most kTreeBranching of the balls (place, depth + s) hold all cells,
/// by halving; at each s balls are taken in the order of how many cells they add. Places farther than `radius` from
/// `center` are left out; the middles of some cells are added as places. Deterministic. Any thread.
GreedyCover cover_greedily(const CoverCells& cells, const std::vector<std::uint32_t>& members,
                           const std::vector<DeepPoint>& points, const Vec3f& center, float radius,
                           const TriangleBvh& bvh, const CoverFrame& frame, std::uint64_t seed,
                           const GreedySettings& settings);

}  // namespace poise::geometry
