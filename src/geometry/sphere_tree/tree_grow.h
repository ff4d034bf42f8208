// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "geometry/sphere_tree/cover/cover_starts.h"
#include "geometry/sphere_tree/cover/solid_cells.h"
#include "geometry/sphere_tree/tree_layout.h"

namespace poise::geometry {

/// What a preset spends.
struct TreeEffort {
  std::size_t cells = 56000;  ///< of a tree of depth 3 or less
  std::size_t start_cells = 6000;
  std::size_t points = 3000;
  std::size_t samples_per_ball = 300;
  StartSettings start;
  LevelSettings level{.bids = 13, .iterations = 3, .redone = 8};
};

TreeEffort effort_of(TreePreset preset);

/// Grows a tree level by level, each level as one cover (docs/sphere-trees.md). `progress` is called on the calling
/// thread with the share done, `keep_going` also on others; when it says no, what comes back is not a tree and is to be
/// thrown away.
std::vector<LooseNode> grow_tree(const TriangleMesh& mesh, const TriangleBvh& bvh, const TreeBuildOptions& options,
                                 parallel::Executor& executor, const std::function<void(double)>& progress,
                                 const std::function<bool()>& keep_going);

}  // namespace poise::geometry
