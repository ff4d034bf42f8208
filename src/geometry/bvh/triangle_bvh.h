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

/// The point of a triangle that is closest to p (Ericson, "Real-Time Collision Detection", 2005, 5.1.5). For a triangle
/// without area, the closest point of its edges.
Vec3 closest_on_triangle(const Vec3& p, const TriangleCorners& t);

/// Closest-point and inside queries on a mesh. Invariant: every triangle is in exactly one slot, and the box and the
/// cluster values of a slot include all triangles below it. Immutable once made; any number of threads may query.
///
/// Nodes have four children with boxes in single precision, relative to the middle of the mesh. The boxes are rounded
/// outward by more than the rounding of a query, so that a search never misses the closest triangle. Distances are
/// computed in double.
class TriangleBvh {
 public:
  static constexpr std::uint32_t kNoTriangle = 0xffffffffU;

  /// With Solidity::Shell no point is inside.
  explicit TriangleBvh(const TriangleMesh& mesh, Solidity solidity = Solidity::Solid);

  struct Closest {
    double squared_distance_m2 = std::numeric_limits<double>::infinity();
    Vec3 point_m = Vec3::Zero();
    std::uint32_t triangle = kNoTriangle;  ///< its index in the mesh
  };
  /// The closest point of the surface, if it is nearer than the given bound; otherwise returns the bound and
  /// kNoTriangle.
  [[nodiscard]] Closest closest(const Vec3& point,
                                double squared_bound_m2 = std::numeric_limits<double>::infinity()) const;
  /// The same without a bound. It is faster the nearer `guess` (the index of a triangle, or kNoTriangle) is to the
  /// closest triangle. If several triangles are equally close and the guess is one of them, the guess is returned.
  [[nodiscard]] Closest closest_from(const Vec3& point, std::uint32_t guess) const;

  /// Winding number of the surface around a point: 1 inside a closed mesh, 0 outside. For a closed mesh it is an
  /// integer: the signed crossings of a ray along an axis, where both triangles of an edge use the same numbers. For an
  /// open mesh: solid angles of nearby triangles (Van Oosterom and Strackee 1983) and dipoles of distant clusters
  /// (Barill et al., "Fast winding numbers", 2018), accurate to 0.3, and to 0.05 near one half.
  [[nodiscard]] double winding_number(const Vec3& point) const;
  /// Whether the winding number is above one half in absolute value; either result is possible for a point on the
  /// surface.
  [[nodiscard]] bool inside(const Vec3& point) const;

  /// Distance to the surface in metres, 0 inside.
  [[nodiscard]] double outside_distance_m(const Vec3& point) const;
  /// Distance to the surface in metres, negative inside.
  [[nodiscard]] double signed_distance_m(const Vec3& point) const;

  [[nodiscard]] std::size_t triangle_count() const { return corners_m_.size(); }
  /// Diagonal of the box around all triangles.
  [[nodiscard]] double diagonal_m() const { return nodes_.empty() ? 0.0 : (box_.high - box_.low).norm(); }
  /// Whether every edge is used equally often in both directions.
  [[nodiscard]] bool closed() const { return closed_; }
  [[nodiscard]] const TriangleCorners& corners(std::uint32_t triangle) const { return corners_m_[position_[triangle]]; }
  /// Unit normal by the order of the corners; 0 for a triangle without area.
  [[nodiscard]] Vec3 triangle_normal(std::uint32_t triangle) const;
  /// Appends the triangles (indices in the mesh) whose box comes within `radius_m` of a point: a superset of the
  /// triangles within that distance.
  void triangles_near(const Vec3& point, double radius_m, std::vector<std::uint32_t>& out) const;
  /// Does the straight way between two points pass a triangle from its front to its back, at 26 degrees or less from
  /// its normal? Those at its ends, within a thousandth of its length, do not count.
  [[nodiscard]] bool enters_between(const Vec3& from, const Vec3& to) const;

  /// The hierarchy, for searches in other modules: nodes with the root first, their boxes relative to origin_m(), and a
  /// leaf's index for corners_at() and triangle_at().
  [[nodiscard]] const std::vector<BvhNode>& nodes() const { return nodes_; }
  [[nodiscard]] const Vec3& origin_m() const { return origin_m_; }
  [[nodiscard]] const Bounds& box() const { return box_; }
  [[nodiscard]] const TriangleCorners& corners_at(std::uint32_t place) const { return corners_m_[place]; }
  [[nodiscard]] std::uint32_t triangle_at(std::uint32_t place) const { return triangle_of_[place]; }
  [[nodiscard]] std::uint32_t place_of(std::uint32_t triangle) const { return position_[triangle]; }

 private:
  void search(const Vec3& point, Closest& best) const;
  // Calls visit(place) for triangles_near(), until it returns true; whether it has.
  template <class Visit>
  bool any_near(const Vec3& point, double radius_m, Visit&& visit) const;
  [[nodiscard]] int crossings(const Vec3& point) const;
  [[nodiscard]] double solid_angles(const Vec3& point, float dipole_from) const;

  Solidity solidity_;
  bool closed_ = false;
  Vec3 origin_m_ = Vec3::Zero();
  Bounds box_;
  std::vector<TriangleCorners> corners_m_;  ///< in the order of the leaves
  std::vector<std::uint32_t> triangle_of_;  ///< index in leaf order -> index in the mesh
  std::vector<std::uint32_t> position_;     ///< index in the mesh -> index in leaf order
  std::vector<BvhNode> nodes_;
  std::vector<BvhClusters> clusters_;  ///< one for each node; empty for a closed mesh
};

}  // namespace poise::geometry
