// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

#include "poise/sphere_tree.h"

namespace poise::geometry {

struct NearestLeaf {
  double distance_m = std::numeric_limits<double>::infinity();  ///< to its sphere, negative inside
  NodeIndex node = 0;
};

/// The leaf whose sphere is nearest to a point; the first of several. Every inner sphere must contain the leaves below
/// it, so that the search can skip subtrees that are farther than the best leaf so far.
NearestLeaf nearest_leaf(const SphereTree& tree, const Vec3& point);

}  // namespace poise::geometry
