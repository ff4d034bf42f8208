// SPDX-License-Identifier: MIT
#pragma once

#include <stop_token>
#include <vector>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/sphere_tree/cover/sphere_patches.h"
#include "parallel/executor.h"
#include "poise/sphere_tree.h"

namespace poise::geometry {

/// For each of `nodes`, the others whose spheres overlap its own, in the order of `nodes`. Sorts and sweeps along x:
/// n^(5/3) for spheres of similar size.
std::vector<std::vector<NodeIndex>> overlapping_nodes(const SphereTree& tree, const std::vector<NodeIndex>& nodes);

/// Whether a point is strictly inside one of the spheres `others`.
bool hidden_by(const SphereTree& tree, const std::vector<NodeIndex>& others, const Vec3& point);

struct ProtrusionOptions {
  double tolerance_m = 0;           ///< bounds this near to the sampled values are not refined further; >= 0
  bool leaves_are_surface = false;  ///< the leaves are the object: they get 0, and only nodes above them are measured
  std::stop_token stop = {};        ///< once it is stopped, no more nodes are measured
};

/// Fills protrusion_max_m and protrusion_mean_m with bounds (sphere_patches.h), rounded up: no exposed point of a
/// node's sphere protrudes farther than the first, and the area-weighted mean is not above the second. A leaf above the
/// deepest level represents itself at deeper levels, where more of it is exposed, so it gets the largest bounds over
/// its levels. The result does not depend on the executor.
void measure_protrusions(SphereTree& tree, const ObjectQueries& object, const ProtrusionOptions& options,
                         parallel::Executor& executor);

/// The same for a mesh. For a closed mesh these are bounds. For an open mesh or a shell they hold for the distance to
/// the surface and for the result of bvh.inside, which has no sharp border. Accurate within 0.02 % of the diagonal or
/// the shares in sphere_patches.h.
void measure_protrusions(SphereTree& tree, const TriangleBvh& bvh, parallel::Executor& executor,
                         const std::stop_token& stop = {});

}  // namespace poise::geometry
