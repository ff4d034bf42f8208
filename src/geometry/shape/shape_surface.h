// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geometry/bvh/triangle_bvh.h"
#include "poise/sphere_tree.h"
#include "poise/types.h"

namespace poise {

/// The triangles of a shape and their overlap with its tree, for the level of polygons. Body frame, metres. Immutable
/// once made; any number of threads may read.
struct ShapeSurface {
  static constexpr std::uint32_t kNone = 0xffffffffU;
  // Bits of Triangle::features.
  static constexpr std::uint8_t kVertex0 = 1;  ///< the triangle owns corner 0; shifted left for corners 1 and 2
  static constexpr float kAnyDirection = 10;
  static constexpr std::uint8_t kEdge0 = 8;  ///< it owns the side from corner 0 to 1; shifted left for the next two

  /// A triangle and a ball around it.
  struct Triangle {
    std::array<std::uint32_t, 3> vertex{};  ///< counter-clockwise from outside
    /// The neighbour across side k (corner k to k + 1); kNone at a rim or where more than two triangles meet.
    std::array<std::uint32_t, 3> across{};
    Vec3 normal = Vec3::Zero();  ///< unit, outward; 0 for a triangle without area
    Vec3 center_m = Vec3::Zero();
    double radius_m = 0;
    /// Corners and sides that this triangle owns; each is owned by at most one triangle of the mesh.
    std::uint8_t features = 0;
    /// Directions in which an owned side, or an owned corner's edges, can be touched lie within this angle of the
    /// normal (radians, rounded up); kAnyDirection where that is not known.
    float spread_rad = kAnyDirection;
  };

  explicit ShapeSurface(geometry::TriangleBvh searched) : bvh(std::move(searched)) {}

  /// The triangle in single precision, for a first test: a ball and a plane, each accurate to `rounding_m`.
  struct TriangleBounds {
    std::array<float, 3> center_m;
    float radius_m;
    std::array<float, 3> normal;  ///< the plane goes through the centre
    float unused;                 ///< padding, so that two records fill a cache line
  };

  /// The triangle in single precision, for a test of many: accurate to what rounds in coordinates from the BVH's
  /// origin.
  struct alignas(64) NearTriangle {
    std::array<std::array<float, 4>, 3> corner;  ///< x, y, z from the BVH's origin, and a component of the normal
    float features;                              ///< the bits of Triangle::features, as a number
    float spread_rad;
    std::array<float, 2> unused;
  };

  bool solid = false;  ///< closed and solid: normals distinguish inside from outside
  std::vector<Vec3> vertices_m;
  std::vector<Vec3> vertex_normal;  ///< angle-weighted sum of the normals around, about unit, 0 for an unused vertex
  std::vector<std::uint32_t> neighbor_begin;  ///< per vertex, then the end
  std::vector<std::uint32_t> neighbors;       ///< vertices that share an edge with it, ascending
  std::vector<Triangle> triangles;
  std::vector<TriangleBounds> triangle_bounds;  ///< one for each triangle
  std::vector<NearTriangle> near_triangles;     ///< the same, in the order of the BVH's leaves
  float rounding_m = 0;
  std::vector<std::uint32_t> leaf_begin;  ///< per node of the tree, then the end; empty for a node that is not a leaf
  std::vector<std::uint32_t> leaf_triangles;       ///< those that meet the leaf's ball, ascending
  std::vector<std::uint32_t> triangle_leaf_begin;  ///< per triangle, then the end
  std::vector<NodeIndex> triangle_leaves;          ///< the leaves that it meets, ascending
  geometry::TriangleBvh bvh;                       ///< same frame and triangles

  [[nodiscard]] std::span<const std::uint32_t> triangles_of(NodeIndex leaf) const {
    return std::span(leaf_triangles).subspan(leaf_begin[leaf], leaf_begin[leaf + 1] - leaf_begin[leaf]);
  }
  [[nodiscard]] std::span<const NodeIndex> leaves_of(std::uint32_t triangle) const {
    return std::span(triangle_leaves)
        .subspan(triangle_leaf_begin[triangle], triangle_leaf_begin[triangle + 1] - triangle_leaf_begin[triangle]);
  }
  [[nodiscard]] std::span<const std::uint32_t> neighbors_of(std::uint32_t vertex) const {
    return std::span(neighbors).subspan(neighbor_begin[vertex], neighbor_begin[vertex + 1] - neighbor_begin[vertex]);
  }
};

namespace geometry {

/// The surface of a mesh moved by -offset_m, and its overlap with the leaves of `tree` (already in the moved frame).
/// The mesh must have been cleaned by clean_mesh, with indices in range. Only corners and sides that can touch first
/// are listed: for a solid the convex ones, for any other surface all that are not flat.
ShapeSurface make_surface(const TriangleMesh& mesh, const Vec3& offset_m, Solidity solidity, const SphereTree& tree);

}  // namespace geometry
}  // namespace poise
