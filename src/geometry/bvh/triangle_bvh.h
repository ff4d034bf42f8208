// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/bvh/triangle_bvh_build.h"
#include "geometry/primitives/bounds.h"
#include "poise/mesh.h"

namespace poise::geometry {

/// The point of a triangle that is closest to p (Ericson, "Real-Time Collision Detection", 2005, 5.1.5); of a triangle
/// without area, the closest point of its edges.
Vec3 closest_on_triangle(const Vec3& p, const TriangleCorners& t);

/// Answers closest-point and inside questions about a mesh. Invariant: every triangle is in exactly one slot, and the
/// box and the cluster figures of a slot hold all triangles below it. Immutable once made; any number of threads may
/// ask.
///
/// Nodes have four children whose boxes are single precision, relative to the middle of the mesh and rounded outward by
/// more than a question's own rounding, so that a search never leaves out what is closest; distances are reckoned in
/// double.
class TriangleBvh {
 public:
  static constexpr std::uint32_t kNoTriangle = 0xffffffffU;

  /// With Solidity::Shell nothing is inside.
  explicit TriangleBvh(const TriangleMesh& mesh, Solidity solidity = Solidity::Solid);

  struct Closest {
    double squared_distance_m2 = std::numeric_limits<double>::infinity();
    Vec3 point_m = Vec3::Zero();
    std::uint32_t triangle = kNoTriangle;  ///< its index in the mesh
  };
  /// The closest point of the surface, if it is nearer than the given bound; else the bound comes back, and
  /// kNoTriangle.
  [[nodiscard]] Closest closest(const Vec3& point,
                                double squared_bound_m2 = std::numeric_limits<double>::infinity()) const;
  /// The same without a bound, quicker the nearer `guess` (the index of a triangle, or kNoTriangle) is to the closest
  /// one. Where several triangles are equally close, the guess is kept.
  [[nodiscard]] Closest closest_from(const Vec3& point, std::uint32_t guess) const;

  /// How often the surface winds around a point: 1 inside a closed mesh, 0 outside. Of a closed mesh it is a whole
  /// number: crossings of a ray along an axis, counted with their signs, each edge alike for both of its triangles. Of
  /// an open one: solid angles of triangles (Van Oosterom and Strackee 1983) nearby, dipoles of clusters farther away
  /// (Barill et al., "Fast winding numbers", 2018), within 0.3, and within 0.05 where that comes near a half.
  [[nodiscard]] double winding_number(const Vec3& point) const;
  /// Whether the surface winds more than half around the point, either way; on the surface either answer may come.
  [[nodiscard]] bool inside(const Vec3& point) const;

  /// Distance to the surface in metres, 0 inside.
  [[nodiscard]] double outside_distance_m(const Vec3& point) const;
  /// Distance to the surface in metres, negative inside.
  [[nodiscard]] double signed_distance_m(const Vec3& point) const;

  [[nodiscard]] std::size_t triangle_count() const { return corners_m_.size(); }
  /// Of the box around all triangles.
  [[nodiscard]] double diagonal_m() const { return nodes_.empty() ? 0.0 : (box_.high - box_.low).norm(); }
  /// Whether every edge is run through in both directions equally often.
  [[nodiscard]] bool closed() const { return closed_; }
  [[nodiscard]] const TriangleCorners& corners(std::uint32_t triangle) const { return corners_m_[position_[triangle]]; }
  /// Unit normal by the order of the corners; 0 for a triangle without area.
  [[nodiscard]] Vec3 triangle_normal(std::uint32_t triangle) const;
  /// Appends the triangles (indices in the mesh) whose box comes within `radius_m` of a point: all that come that near,
  /// and some more.
  void triangles_near(const Vec3& point, double radius_m, std::vector<std::uint32_t>& out) const;

  /// The hierarchy, for searches of other rooms: nodes with the root first, their boxes relative to origin_m(), and a
  /// leaf's place in corners_at() and triangle_at().
  [[nodiscard]] const std::vector<BvhNode>& nodes() const { return nodes_; }
  [[nodiscard]] const Vec3& origin_m() const { return origin_m_; }
  [[nodiscard]] const Bounds& box() const { return box_; }
  [[nodiscard]] const TriangleCorners& corners_at(std::uint32_t place) const { return corners_m_[place]; }
  [[nodiscard]] std::uint32_t triangle_at(std::uint32_t place) const { return triangle_of_[place]; }

 private:
  void search(const Vec3& point, Closest& best) const;
  [[nodiscard]] int crossings(const Vec3& point) const;
  [[nodiscard]] double solid_angles(const Vec3& point, float dipole_from) const;

  Solidity solidity_;
  bool closed_ = false;
  Vec3 origin_m_ = Vec3::Zero();
  Bounds box_;
  std::vector<TriangleCorners> corners_m_;  ///< in the order of the leaves
  std::vector<std::uint32_t> triangle_of_;  ///< place -> index in the mesh
  std::vector<std::uint32_t> position_;     ///< index in the mesh -> place
  std::vector<BvhNode> nodes_;
  std::vector<BvhClusters> clusters_;  ///< beside nodes_; empty for a closed mesh
};

}  // namespace poise::geometry
