// SPDX-License-Identifier: MIT
#include "collision/triangles/true_surface.h"

#include <algorithm>
#include <cmath>

#include "geometry/primitives/triangle_distance.h"
#include "geometry/shape/shape_surface.h"

namespace poise::collision {

using geometry::BallTree;
using geometry::TriangleCorners;

/// Two surfaces, the second one seen from the frame of the first.
struct TrueSurface::Between {
  const TrueSurface& a;
  const TrueSurface& b;
  Mat3 rotation;
  Vec3 offset_m;

  struct Waiting {
    std::uint32_t a, b;
    double bound_m;
  };

  [[nodiscard]] Vec3 moved(const Vec3& p) const { return rotation * p + offset_m; }

  [[nodiscard]] Waiting waiting(std::uint32_t node_a, std::uint32_t node_b) const {
    const BallTree::Node& na = a.tree_.nodes()[node_a];
    const BallTree::Node& nb = b.tree_.nodes()[node_b];
    return {node_a, node_b, (moved(nb.center_m) - na.center_m).norm() - na.radius_m - nb.radius_m};
  }

  [[nodiscard]] double of_parts_m(std::uint32_t part_a, std::uint32_t part_b) const {
    const Sphere& ball_a = a.balls_m_[part_a];
    const Sphere& ball_b = b.balls_m_[part_b];
    if (a.kind_ == Kind::Balls && b.kind_ == Kind::Balls) {
      return std::max(0.0, (moved(ball_b.center_m) - ball_a.center_m).norm() - ball_a.radius_m - ball_b.radius_m);
    }
    if (a.kind_ == Kind::Balls) {
      const Vec3 center = rotation.transpose() * (ball_a.center_m - offset_m);
      return ball_to_triangle_m(center, ball_a.radius_m, b.triangles_m_[part_b]);
    }
    if (b.kind_ == Kind::Balls) {
      return ball_to_triangle_m(moved(ball_b.center_m), ball_b.radius_m, a.triangles_m_[part_a]);
    }
    const TriangleCorners& t = b.triangles_m_[part_b];
    return geometry::distance_of_triangles_m(a.triangles_m_[part_a], {moved(t[0]), moved(t[1]), moved(t[2])});
  }

  [[nodiscard]] double of_leaves_m(const BallTree::Node& na, const BallTree::Node& nb, double least_m) const {
    for (std::uint32_t i = na.begin; i < na.end; ++i) {
      const std::uint32_t part_a = a.tree_.order()[i];
      for (std::uint32_t j = nb.begin; j < nb.end; ++j) {
        const std::uint32_t part_b = b.tree_.order()[j];
        const Sphere& ball_a = a.balls_m_[part_a];
        const Sphere& ball_b = b.balls_m_[part_b];
        const double bound_m = (moved(ball_b.center_m) - ball_a.center_m).norm() - ball_a.radius_m - ball_b.radius_m;
        if (bound_m < least_m) least_m = std::min(least_m, of_parts_m(part_a, part_b));
      }
    }
    return least_m;
  }

  [[nodiscard]] double least_m(double limit_m) const {
    double least = limit_m;
    std::vector<Waiting> stack{waiting(0, 0)};
    while (!stack.empty() && least > 0) {
      const Waiting top = stack.back();
      stack.pop_back();
      if (top.bound_m >= least) continue;
      const BallTree::Node& na = a.tree_.nodes()[top.a];
      const BallTree::Node& nb = b.tree_.nodes()[top.b];
      if (na.leaf() && nb.leaf()) {
        least = of_leaves_m(na, nb, least);
        continue;
      }
      const bool split_a = nb.leaf() || (!na.leaf() && na.radius_m >= nb.radius_m);
      Waiting near = split_a ? waiting(top.a + 1, top.b) : waiting(top.a, top.b + 1);
      Waiting far = split_a ? waiting(na.right, top.b) : waiting(top.a, nb.right);
      if (far.bound_m < near.bound_m) std::swap(near, far);
      stack.push_back(far);
      stack.push_back(near);
    }
    return least;
  }

  static double ball_to_triangle_m(const Vec3& center, double radius_m, const TriangleCorners& t) {
    return std::max(0.0, (geometry::closest_on_triangle(center, t) - center).norm() - radius_m);
  }
};

TrueSurface::TrueSurface(const TriangleMesh& mesh, Solidity solidity) : kind_(Kind::Triangles) {
  triangles_m_.reserve(mesh.triangles.size());
  balls_m_.reserve(mesh.triangles.size());
  for (const auto& corner : mesh.triangles) {
    const TriangleCorners t{mesh.vertices_m[corner[0]], mesh.vertices_m[corner[1]], mesh.vertices_m[corner[2]]};
    Sphere ball;
    ball.center_m = (t[0] + t[1] + t[2]) / 3;
    for (const Vec3& p : t) ball.radius_m = std::max(ball.radius_m, (p - ball.center_m).norm() * (1 + 1e-12));
    triangles_m_.push_back(t);
    balls_m_.push_back(ball);
  }
  tree_ = BallTree(balls_m_);
  if (solidity == Solidity::Solid && check_closed(mesh).closed()) {
    inside_ = std::make_unique<geometry::TriangleBvh>(mesh, solidity);
  }
}

TrueSurface::TrueSurface(std::span<const Sphere> balls)
    : kind_(Kind::Balls), balls_m_(balls.begin(), balls.end()), tree_(balls_m_) {}

TrueSurface::TrueSurface(const Vec3& normal, double offset_m)
    : kind_(Kind::Plane), normal_(normal), offset_m_(offset_m) {}

bool TrueSurface::blocks(const Vec3& from, const Vec3& to) const {
  if (kind_ == Kind::Plane) return (normal_.dot(from) > offset_m_) != (normal_.dot(to) > offset_m_);
  return tree_.any_along(from, to, [&](std::uint32_t part) {
    if (kind_ == Kind::Triangles) return geometry::segment_meets_triangle(from, to, triangles_m_[part]);
    const Sphere& ball = balls_m_[part];
    if (geometry::distance_to_segment_m(ball.center_m, from, to) >= ball.radius_m) return false;
    return (from - ball.center_m).norm() >= ball.radius_m || (to - ball.center_m).norm() >= ball.radius_m;
  });
}

double TrueSurface::height_of_part_m(std::uint32_t part, const Vec3& normal) const {
  if (kind_ == Kind::Balls) return normal.dot(balls_m_[part].center_m) - balls_m_[part].radius_m;
  const TriangleCorners& t = triangles_m_[part];
  return std::min({normal.dot(t[0]), normal.dot(t[1]), normal.dot(t[2])});
}

double TrueSurface::least_height_m(const Vec3& normal) const {
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t part = 0; part < balls_m_.size(); ++part) least = std::min(least, height_of_part_m(part, normal));
  return least;
}

Vec3 TrueSurface::some_point() const { return kind_ == Kind::Triangles ? triangles_m_[0][0] : balls_m_[0].center_m; }

bool TrueSurface::contains(const Vec3& point) const { return inside_ && inside_->inside(point); }

TrueSurface true_surface_of(const Shape& shape) {
  if (shape.kind == ShapeKind::Plane) return {shape.plane_normal, shape.plane_offset_m};
  if (shape.surface) {
    TriangleMesh mesh;
    mesh.vertices_m = shape.surface->vertices_m;
    for (const ShapeSurface::Triangle& t : shape.surface->triangles) mesh.triangles.push_back(t.vertex);
    return {mesh, shape.surface->solid ? Solidity::Solid : Solidity::Shell};
  }
  std::vector<Sphere> leaves;
  for (const NodeIndex node : shape.tree.nodes_at(shape.tree.depth())) leaves.push_back(shape.tree.sphere(node));
  return TrueSurface(leaves);
}

double surface_distance_m(const TrueSurface& a, const Pose& pose_a, const TrueSurface& b, const Pose& pose_b,
                          double limit_m) {
  using Kind = TrueSurface::Kind;
  if (a.kind_ == Kind::Plane && b.kind_ == Kind::Plane) return 0;
  if (a.kind_ == Kind::Plane) return surface_distance_m(b, pose_b, a, pose_a, limit_m);
  const Mat3 to_a = pose_a.rotation.transpose();
  if (b.kind_ == Kind::Plane) {
    const Vec3 normal = pose_b.rotation * b.normal_;
    const double height_m = normal.dot(pose_a.position_m - pose_b.position_m) - b.offset_m_;
    return std::clamp(height_m + a.least_height_m(to_a * normal), 0.0, limit_m);
  }
  const TrueSurface::Between between{a, b, to_a * pose_b.rotation, to_a * (pose_b.position_m - pose_a.position_m)};
  const double least = between.least_m(limit_m);
  if (least == 0) return 0;
  const bool inside = a.contains(between.moved(b.some_point())) ||
                      b.contains(between.rotation.transpose() * (a.some_point() - between.offset_m));
  return inside ? 0.0 : least;
}

}  // namespace poise::collision
