// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/solid_atoms.h"
#include "geometry/triangle_bvh.h"
#include "poise/sphere_tree.h"

namespace poise::geometry {

/// A ball over some atoms, and how far it can stand out of the solid at most: radius + signed distance of its centre
/// (negative inside). The bound is below 0 for a ball wholly inside.
struct DeepBall {
  Sphere sphere;
  double protrusion_bound_m = 0;
};

/// Starts from the smallest ball that holds all points of the atoms and moves its centre by a pattern search to make
/// protrusion bound + kSizeWeight * radius small. Any thread.
DeepBall deep_ball(const SolidAtoms& atoms, std::span<const std::uint32_t> members, const TriangleBvh& bvh, double size_weight);

struct SplitGroup {
  std::vector<std::uint32_t> members;  ///< atoms, ascending
  DeepBall ball;
};

/// Splits atoms into at most kTreeBranching groups: several starts, Lloyd rounds by the middles of the atoms, then rounds that give
/// each atom to the ball that would have to grow least; the start whose balls stand out least counts. Deterministic. Any thread.
std::vector<SplitGroup> split_atoms(const SolidAtoms& atoms, std::span<const std::uint32_t> members, const TriangleBvh& bvh,
                                    std::uint64_t seed);

}  // namespace poise::geometry
