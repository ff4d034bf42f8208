// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "poise/sphere_tree.h"

namespace poise::geometry {

/// A node of a tree under construction; its sphere is final, with stored precision.
struct LooseNode {
  Eigen::Vector3f center_m = Eigen::Vector3f::Zero();
  float radius_m = 0;
  std::vector<std::uint32_t> children;  ///< indices of loose nodes, at most kTreeBranching; empty for a leaf
};

/// Copies loose nodes into the flat form, level after level. Node 0 is the root; nodes that cannot be reached from it
/// are omitted; protrusions are 0. Deterministic.
SphereTree flatten_tree(const std::vector<LooseNode>& nodes);

/// Adds (or restores) the padding at the end of each array.
void pad_tree(SphereTree& tree);

/// Moves a tree by -offset_m. Spheres grow so that the rounding of the moved centres never uncovers a point. With
/// `leaves_are_surface` the leaves keep their radius, because the object is their union, and only nodes above them
/// grow.
void recenter_tree(SphereTree& tree, const Vec3& offset_m, bool leaves_are_surface);

}  // namespace poise::geometry
