// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "parallel/executor.h"
#include "poise/sphere_tree.h"

namespace poise::geometry {

/// Distance in metres from a point to the object where the point is outside it, 0 inside. Called from any thread.
using OutsideDistance = std::function<double(const Vec3&)>;

/// For each of `nodes`, those others of them whose spheres overlap its own, in order.
std::vector<std::vector<NodeIndex>> overlapping_nodes(const SphereTree& tree, const std::vector<NodeIndex>& nodes,
                                                      parallel::Executor& executor);

/// Whether a point is strictly inside one of the spheres `others`.
bool hidden_by(const SphereTree& tree, const std::vector<NodeIndex>& others, const Vec3& point);

/// Fills protrusion_max_m and protrusion_mean_m by sampling each sphere evenly at `samples` points. A leaf above the deepest
/// level stands for itself below, where more of it is exposed, so it gets the largest over the levels it serves. The result
/// does not depend on the executor.
void measure_protrusions(SphereTree& tree, const OutsideDistance& outside_m, int samples, parallel::Executor& executor);

}  // namespace poise::geometry
