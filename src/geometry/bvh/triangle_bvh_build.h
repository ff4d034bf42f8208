// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/primitives/bounds.h"
#include "poise/mesh.h"

namespace poise::geometry {

using TriangleCorners = std::array<Vec3, 3>;

/// Boxes of four children, in metres from the middle of the mesh; each contains everything below its child.
struct BvhNode {
  using Four = Eigen::Array4f;
  static constexpr std::uint32_t kTriangle = 0x80000000U;  ///< bit set: the other bits are a triangle's index in leaf
                                                           ///< order; else a node
  static constexpr std::uint32_t kNone = 0xffffffffU;      ///< no child; its box is empty
  std::array<Four, 3> low;
  std::array<Four, 3> high;
  std::array<std::uint32_t, 4> child;
};

/// Data for winding queries at distant points: a dipole for each of a node's four children.
struct BvhClusters {
  using Four = Eigen::Array4f;
  std::array<Four, 3> middle;       ///< area-weighted, in metres from the middle of the mesh
  std::array<Four, 3> area_normal;  ///< sum of the triangles' area vectors, in square metres
  Four reach2;                      ///< squared distance from the middle to the farthest corner; negative for no child
};

struct BvhLayout {
  std::vector<std::uint32_t> order;  ///< index in leaf order -> index of a triangle in the mesh
  std::vector<BvhNode> nodes;        ///< the root first, parents before their children; at most 63 levels
};

/// Splits triangles where the sum of surface area times count is least over 16 bins of the longest axis (Wald, "On fast
/// construction of SAH-based bounding volume hierarchies", 2007). Below a depth that only degenerate meshes reach,
/// splits in the middle. Deterministic. `box` bounds the mesh.
BvhLayout flatten_bvh(const TriangleMesh& mesh, const Bounds& box);

/// The clusters of all nodes; corners in leaf order.
std::vector<BvhClusters> clusters_of(std::span<const BvhNode> nodes, std::span<const TriangleCorners> corners_m,
                                     const Vec3& origin_m);

}  // namespace poise::geometry
