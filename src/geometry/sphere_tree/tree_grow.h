// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "geometry/sphere_tree/cover/cover_starts.h"
#include "geometry/sphere_tree/cover/solid_cells.h"
#include "geometry/sphere_tree/tree_layout.h"

namespace poise::geometry {

/// Limits of the work of a preset.
struct TreeEffort {
  std::size_t cells = 56000;  ///< for a tree of depth 3 or less
  std::size_t start_cells = 6000;
  std::size_t points = 3000;
  std::size_t samples_per_ball = 300;
  StartSettings start;
  LevelSettings level{.bids = 13, .iterations = 3, .redone = 8};
};

TreeEffort effort_of(TreePreset preset);

/// Grows a tree level by level, each level as one cover (docs/sphere-trees.md). Calls `progress` on the calling thread
/// with the completed share, and `keep_going` on any thread. If `keep_going` returns false, the result is not a valid
/// tree and must be discarded.
std::vector<LooseNode> grow_tree(const TriangleMesh& mesh, const TriangleBvh& bvh, const TreeBuildOptions& options,
                                 parallel::Executor& executor, const std::function<void(double)>& progress,
                                 const std::function<bool()>& keep_going);

}  // namespace poise::geometry
