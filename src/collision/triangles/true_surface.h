// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "collision/front/pair_frame.h"
#include "geometry/bvh/ball_tree.h"
#include "geometry/bvh/triangle_bvh.h"
#include "poise/mesh.h"
#include "poise/shape.h"

namespace poise::collision {

/// The true surface of a body, for verification: the triangles of its mesh, the spheres that it is made of, or a plane,
/// in the body frame. Slow and exact; no frame uses it. Immutable once made; any thread may ask.
class TrueSurface {
 public:
  /// Triangles with valid indices; with Solidity::Solid what they wind around belongs to the object.
  TrueSurface(const TriangleMesh& mesh, Solidity solidity);
  /// A union of balls, at least one.
  explicit TrueSurface(std::span<const Sphere> balls);
  /// The half-space normal . x <= offset_m; normal unit.
  TrueSurface(const Vec3& normal, double offset_m);

  /// True if the segment from one point to another, in the body frame, passes through the surface. The inside of a ball
  /// is taken for surface unless both ends are in it.
  [[nodiscard]] bool blocks(const Vec3& from, const Vec3& to) const;

 private:
  friend double surface_distance_m(const TrueSurface& a, const Pose& pose_a, const TrueSurface& b, const Pose& pose_b,
                                   double limit_m);
  struct Between;
  enum class Kind : std::uint8_t { Triangles, Balls, Plane };

  [[nodiscard]] double height_of_part_m(std::uint32_t part, const Vec3& normal) const;
  [[nodiscard]] double least_height_m(const Vec3& normal) const;
  [[nodiscard]] Vec3 some_point() const;
  [[nodiscard]] bool contains(const Vec3& point) const;

  Kind kind_;
  std::vector<geometry::TriangleCorners> triangles_m_;
  std::vector<Sphere> balls_m_;                    ///< the balls, or a ball around each triangle
  geometry::BallTree tree_;                        ///< over balls_m_
  std::unique_ptr<geometry::TriangleBvh> inside_;  ///< of a closed solid
  Vec3 normal_ = Vec3::UnitZ();
  double offset_m_ = 0;
};

/// The true surface of a shape: its mesh where it has one, else the leaves of its tree.
TrueSurface true_surface_of(const Shape& shape);

/// Distance of two bodies by their true surfaces, in metres: 0 where they meet or one holds the other (of an object in
/// several pieces one corner is tried); `limit_m` where they are farther apart than that. Two bounding-ball trees
/// descended together, nearest first (Quinlan, "Efficient distance computation between non-convex objects", 1994),
/// exact at the end. Two planes are 0 apart. Any thread.
double surface_distance_m(const TrueSurface& a, const Pose& pose_a, const TrueSurface& b, const Pose& pose_b,
                          double limit_m = std::numeric_limits<double>::infinity());

}  // namespace poise::collision
