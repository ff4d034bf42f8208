// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "geometry/sphere_tree/cover/greedy_cover.h"
#include "geometry/sphere_tree/cover/level_cover.h"
#include "parallel/executor.h"

namespace poise::geometry {

/// Data that every stage of building one tree needs. It must outlive them.
struct CoverScene {
  const TriangleMesh& mesh;
  const TriangleBvh& bvh;
  const CoverFrame& frame;
  const std::vector<DeepPoint>& points;
  std::uint64_t seed;
};

struct StartSettings {
  int tries = 9;
  std::size_t samples = 15000;
  LevelSettings level{.bids = 12, .iterations = 2};
};

/// Searches for the balls of level 1 with coarse cells. Several random covers are improved. They are compared by their
/// own stand-off and by the stand-off of the balls below, estimated by a fast greedy cover of each. Returns the best
/// one, with cells from `cells`. Tries run in parallel; the result does not depend on the executor.
std::vector<CoverBall> find_start(const CoverScene& scene, const CoverCells& cells, const CoverParent& root,
                                  const StartSettings& settings, parallel::Executor& executor,
                                  const std::function<bool()>& keep_going);

/// Balls at the points of a greedy cover, below one parent.
std::vector<CoverBall> balls_of(const GreedyCover& cover, std::uint32_t parent);

}  // namespace poise::geometry
