// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/bounds.h"
#include "poise/mesh.h"

namespace poise::geometry {

/// Answers closest-point and inside questions about a mesh. Invariant: every triangle is in exactly one leaf, and a
/// node's box and cluster figures hold all triangles below it. Immutable once made; any number of threads may ask.
class TriangleBvh {
 public:
  explicit TriangleBvh(const TriangleMesh& mesh);

  struct Closest {
    double squared_distance_m2 = std::numeric_limits<double>::infinity();
    Vec3 point_m = Vec3::Zero();
  };
  /// The closest point of the surface, if it is nearer than the given bound; else the bound comes back.
  [[nodiscard]] Closest closest(const Vec3& point, double squared_bound_m2 = std::numeric_limits<double>::infinity()) const;

  /// How often the surface winds around a point: 1 inside a closed mesh, 0 outside. Solid angles of triangles (Van Oosterom and
  /// Strackee 1983) nearby, dipoles of clusters farther away (Barill et al., "Fast winding numbers", 2018); within 0.3.
  [[nodiscard]] double winding_number(const Vec3& point) const;
  /// Whether the surface winds around the point, either way; on the surface either answer may come.
  [[nodiscard]] bool inside(const Vec3& point) const;

  /// Distance to the surface in metres, 0 inside.
  [[nodiscard]] double outside_distance_m(const Vec3& point) const;
  /// Distance to the surface in metres, negative inside.
  [[nodiscard]] double signed_distance_m(const Vec3& point) const;

 private:
  struct Node {
    Bounds box;
    Vec3 area_normal_m2 = Vec3::Zero();  ///< sum of the triangles' area vectors
    Vec3 middle_m = Vec3::Zero();        ///< area-weighted middle of the triangles
    double reach_m = 0;                  ///< from the middle to the farthest corner
    std::uint32_t first = 0;             ///< first triangle
    std::uint32_t count = 0;             ///< triangles below
    std::uint32_t right = 0;             ///< the second child, 0 for a leaf; the first one is the next node
  };

  std::uint32_t build(std::uint32_t first, std::uint32_t count);
  void sum_up(Node& node) const;
  void search(std::uint32_t index, const Vec3& point, Closest& best) const;
  [[nodiscard]] double winding_below(std::uint32_t index, const Vec3& point) const;

  std::vector<std::array<Vec3, 3>> corners_m_;
  std::vector<Node> nodes_;
};

}  // namespace poise::geometry
