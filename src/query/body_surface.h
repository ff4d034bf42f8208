// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/bvh/ball_tree.h"
#include "geometry/primitives/bounds.h"
#include "geometry/shape/shape_surface.h"
#include "poise/shape.h"

namespace poise::query {

/// A point on a surface, in the frame of the query.
struct SurfacePoint {
  double distance_m = 0;  ///< along a ray; for a closest point the distance, negative inside a solid
  Vec3 point_m = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  bool at_start = false;  ///< it was inside, or overlapping, at the start
};

/// The true surface of a shape for queries, in the body frame: the triangles of its mesh, the leaves of its tree, or
/// its plane. Exact up to rounding. Immutable once made; any thread may query. Directions must be unit, and all numbers
/// finite except distance limits.
class BodySurface {
 public:
  explicit BodySurface(ShapePtr shape);

  [[nodiscard]] const ShapePtr& shape() const { return shape_; }
  [[nodiscard]] bool is_plane() const { return shape_->kind == ShapeKind::Plane; }
  /// A box around the surface; empty for a plane.
  [[nodiscard]] const geometry::Bounds& box() const { return box_; }
  /// Whether the shape is solid and contains the point.
  [[nodiscard]] bool contains(const Vec3& point) const;

  /// The first point of a ray within limit_m. Normals as in poise::RayHit.
  [[nodiscard]] std::optional<SurfacePoint> cast_ray(const Vec3& origin_m, const Vec3& direction, double limit_m,
                                                     bool leaves_solids) const;
  /// The first contact of a moving sphere within limit_m.
  [[nodiscard]] std::optional<SurfacePoint> cast_sphere(const Vec3& center_m, double radius_m, const Vec3& direction,
                                                        double limit_m) const;
  /// Whether the surface meets the ball, or a solid contains it.
  [[nodiscard]] bool overlaps_ball(const Vec3& center_m, double radius_m) const;
  /// Whether the surface meets the box, or a solid contains it. A point x of the body is rotation * x + offset_m in the
  /// frame of the box.
  [[nodiscard]] bool overlaps_box(const Mat3& rotation, const Vec3& offset_m, const Vec3& half_extents_m) const;
  /// The nearest point of the surface, if the absolute distance is at most limit_m.
  [[nodiscard]] std::optional<SurfacePoint> closest(const Vec3& point, double limit_m) const;

 private:
  [[nodiscard]] const geometry::TriangleBvh& triangles() const { return shape_->surface->bvh; }
  [[nodiscard]] std::optional<SurfacePoint> ray_to_triangles(const Vec3& origin_m, const Vec3& direction,
                                                             double limit_m) const;
  [[nodiscard]] std::optional<SurfacePoint> ray_to_balls(const Vec3& origin_m, const Vec3& direction, double limit_m,
                                                         double grown_m) const;
  [[nodiscard]] std::optional<SurfacePoint> ray_out_of_balls(const Vec3& origin_m, const Vec3& direction,
                                                             double limit_m) const;
  [[nodiscard]] std::optional<SurfacePoint> ray_to_plane(const Vec3& origin_m, const Vec3& direction, double limit_m,
                                                         double grown_m) const;
  [[nodiscard]] std::optional<SurfacePoint> sphere_to_triangles(const Vec3& center_m, double radius_m,
                                                                const Vec3& direction, double limit_m) const;
  [[nodiscard]] std::optional<SurfacePoint> closest_of_triangles(const Vec3& point, double limit_m) const;
  [[nodiscard]] SurfacePoint closest_of_balls(const Vec3& point) const;

  ShapePtr shape_;
  geometry::Bounds box_;
  std::vector<Sphere> balls_m_;  ///< leaves; empty for meshes and planes
  geometry::BallTree tree_;      ///< over balls_m_
};

}  // namespace poise::query
