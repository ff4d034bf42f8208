// SPDX-License-Identifier: MIT
#include "query/body_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "query/bvh_walk.h"
#include "query/triangle_queries.h"

namespace poise::query {
namespace {

using geometry::BallTree;
using geometry::Bounds;

/// Distance by which the origin of a ray is moved toward a ball, so that no digits are lost for a far origin.
double approach_m(const Vec3& origin_m, const Vec3& direction, const Bounds& box, double grown_m) {
  const Vec3 from = origin_m - box.center();
  const double reach_m = 0.5 * (box.high - box.low).norm() + grown_m;
  return std::max(0.0, -from.dot(direction) - reach_m - 1e-9 * from.norm());
}

/// Calls visit(ball) for balls of the tree, nearer nodes first; bound(node) as in walk().
template <class Bound, class Limit, class Visit>
void walk_balls(const BallTree& tree, Bound&& bound, Limit&& limit, Visit&& visit) {
  if (tree.nodes().empty()) return;
  struct Waiting {
    double least;
    std::uint32_t node;
  };
  // Ranges are halved each time: at most 32 levels, with one node a level on the stack.
  std::array<Waiting, 64> waiting;
  std::size_t count = 0;
  waiting[count++] = {bound(tree.nodes()[0]), 0};
  while (count > 0) {
    const Waiting top = waiting[--count];
    if (!(top.least <= limit()) || top.least == kMiss) continue;
    const BallTree::Node& node = tree.nodes()[top.node];
    if (node.leaf()) {
      for (std::uint32_t place = node.begin; place < node.end; ++place) visit(tree.order()[place]);
      continue;
    }
    Waiting near{bound(tree.nodes()[top.node + 1]), top.node + 1};
    Waiting far{bound(tree.nodes()[node.right]), node.right};
    if (far.least < near.least) std::swap(near, far);
    waiting[count++] = far;
    waiting[count++] = near;
  }
}

Vec3 unit_or(const Vec3& v, const Vec3& otherwise) {
  const double length = v.norm();
  return length > 0 ? Vec3(v / length) : otherwise;
}

std::optional<SurfacePoint> from_start(const Vec3& origin_m, const Vec3& direction) {
  return SurfacePoint{0, origin_m, -direction, true};
}

}  // namespace

BodySurface::BodySurface(ShapePtr shape) : shape_(std::move(shape)) {
  if (is_plane()) return;
  if (shape_->surface) {
    box_ = triangles().box();
    return;
  }
  const SphereTree& tree = shape_->tree;
  for (const NodeIndex node : tree.nodes_at(tree.depth())) balls_m_.push_back(tree.sphere(node));
  for (const Sphere& ball : balls_m_) {
    box_.add(ball.center_m - Vec3::Constant(ball.radius_m));
    box_.add(ball.center_m + Vec3::Constant(ball.radius_m));
  }
  tree_ = BallTree(balls_m_);
}

bool BodySurface::contains(const Vec3& point) const {
  if (is_plane()) return shape_->plane_normal.dot(point) <= shape_->plane_offset_m;
  if (shape_->surface) return shape_->surface->solid && box_.squared_distance(point) == 0 && triangles().inside(point);
  bool held = false;
  walk_balls(
      tree_, [&](const BallTree::Node& node) { return (point - node.center_m).norm() - node.radius_m; },
      [&] { return held ? -kMiss : 0.0; },
      [&](std::uint32_t i) { held |= (point - balls_m_[i].center_m).norm() <= balls_m_[i].radius_m; });
  return held;
}

std::optional<SurfacePoint> BodySurface::ray_to_plane(const Vec3& origin_m, const Vec3& direction, double limit_m,
                                                      double grown_m) const {
  const Vec3& normal = shape_->plane_normal;
  const double height_m = normal.dot(origin_m) - shape_->plane_offset_m - grown_m;
  const double speed = normal.dot(direction);
  if (speed == 0) return std::nullopt;
  const double distance_m = -height_m / speed;
  if (!(distance_m >= 0 && distance_m <= limit_m)) return std::nullopt;
  return SurfacePoint{distance_m, origin_m + distance_m * direction - grown_m * normal, normal, false};
}

std::optional<SurfacePoint> BodySurface::ray_to_triangles(const Vec3& origin_m, const Vec3& direction,
                                                          double limit_m) const {
  const double start_m = approach_m(origin_m, direction, box_, 0);
  if (start_m > limit_m) return std::nullopt;
  const Vec3 from = origin_m + start_m * direction;
  const TriangleRay ray(from, direction);
  const BoxRay boxes(from, direction, 0);
  double least_m = limit_m - start_m;
  std::uint32_t hit = geometry::TriangleBvh::kNoTriangle;
  walk(
      triangles(), [&](const Vec3& low, const Vec3& high) { return boxes.enters_m(low, high); },
      [&] { return least_m; },
      [&](std::uint32_t place) {
        const double distance_m = ray.distance_m(triangles().corners_at(place));
        const std::uint32_t triangle = triangles().triangle_at(place);
        // Of triangles that are hit at the same distance, as at an edge, the one with the lowest index is returned.
        const bool nearer = distance_m < least_m || (distance_m == least_m && triangle < hit);
        if (distance_m < kMiss && nearer) {
          least_m = distance_m;
          hit = triangle;
        }
        return false;
      });
  if (hit == geometry::TriangleBvh::kNoTriangle) return std::nullopt;
  Vec3 normal = unit_or(normal_of(triangles().corners(hit)), -direction);
  if (!shape_->surface->solid && normal.dot(direction) > 0) normal = -normal;
  return SurfacePoint{start_m + least_m, from + least_m * direction, normal, false};
}

std::optional<SurfacePoint> BodySurface::ray_to_balls(const Vec3& origin_m, const Vec3& direction, double limit_m,
                                                      double grown_m) const {
  double least_m = limit_m;
  std::optional<std::uint32_t> hit;
  walk_balls(
      tree_,
      [&](const BallTree::Node& node) {
        const double r = (node.radius_m + grown_m) * (1 + 1e-12);
        const BallCrossing crossing = crossing_of_ball(origin_m, direction, node.center_m, r);
        if (crossing.enters_m == kMiss || crossing.leaves_m < 0) return kMiss;
        return std::max(0.0, crossing.enters_m) * (1 - 1e-12);
      },
      [&] { return least_m; },
      [&](std::uint32_t i) {
        const BallCrossing crossing =
            crossing_of_ball(origin_m, direction, balls_m_[i].center_m, balls_m_[i].radius_m + grown_m);
        if (crossing.enters_m == kMiss || crossing.leaves_m < 0) return;
        // A sphere that rounding has put slightly inside touches immediately if it moves closer.
        if (crossing.enters_m < 0 && crossing.enters_m + crossing.leaves_m <= 0) return;
        const double distance_m = std::max(0.0, crossing.enters_m);
        if (distance_m < least_m || (distance_m == least_m && (!hit || i < *hit))) {
          least_m = distance_m;
          hit = i;
        }
      });
  if (!hit) return std::nullopt;
  const Sphere& ball = balls_m_[*hit];
  const Vec3 normal = unit_or(origin_m + least_m * direction - ball.center_m, -direction);
  return SurfacePoint{least_m, ball.center_m + ball.radius_m * normal, normal, false};
}

std::optional<SurfacePoint> BodySurface::ray_out_of_balls(const Vec3& origin_m, const Vec3& direction,
                                                          double limit_m) const {
  struct Inside {
    BallCrossing crossing;
    std::uint32_t ball;
  };
  std::vector<Inside> along;
  for (std::uint32_t i = 0; i < balls_m_.size(); ++i) {
    const BallCrossing crossing = crossing_of_ball(origin_m, direction, balls_m_[i].center_m, balls_m_[i].radius_m);
    if (crossing.enters_m < kMiss && crossing.leaves_m >= 0) along.push_back({crossing, i});
  }
  std::ranges::sort(along, [](const Inside& x, const Inside& y) { return x.crossing.enters_m < y.crossing.enters_m; });
  double out_m = 0;
  std::optional<std::uint32_t> last;
  for (const Inside& inside : along) {
    if (inside.crossing.enters_m > out_m) break;
    if (inside.crossing.leaves_m < out_m) continue;
    out_m = inside.crossing.leaves_m;
    last = inside.ball;
  }
  if (!last || out_m > limit_m) return std::nullopt;
  const Vec3 point = origin_m + out_m * direction;
  return SurfacePoint{out_m, point, unit_or(point - balls_m_[*last].center_m, direction), false};
}

std::optional<SurfacePoint> BodySurface::cast_ray(const Vec3& origin_m, const Vec3& direction, double limit_m,
                                                  bool leaves_solids) const {
  const bool inside = contains(origin_m);
  if (inside && !leaves_solids) return from_start(origin_m, direction);
  if (is_plane()) return ray_to_plane(origin_m, direction, limit_m, 0);
  if (shape_->surface) return ray_to_triangles(origin_m, direction, limit_m);
  return inside ? ray_out_of_balls(origin_m, direction, limit_m) : ray_to_balls(origin_m, direction, limit_m, 0);
}

std::optional<SurfacePoint> BodySurface::sphere_to_triangles(const Vec3& center_m, double radius_m,
                                                             const Vec3& direction, double limit_m) const {
  const double start_m = approach_m(center_m, direction, box_, radius_m);
  if (start_m > limit_m) return std::nullopt;
  const Vec3 from = center_m + start_m * direction;
  const BoxRay boxes(from, direction, radius_m);
  double least_m = limit_m - start_m;
  std::uint32_t hit = geometry::TriangleBvh::kNoTriangle;
  walk(
      triangles(), [&](const Vec3& low, const Vec3& high) { return boxes.enters_m(low, high); },
      [&] { return least_m; },
      [&](std::uint32_t place) {
        const double distance_m = sphere_to_triangle_m(from, radius_m, direction, triangles().corners_at(place));
        const std::uint32_t triangle = triangles().triangle_at(place);
        const bool nearer = distance_m < least_m || (distance_m == least_m && triangle < hit);
        if (distance_m < kMiss && nearer) {
          least_m = distance_m;
          hit = triangle;
        }
        return false;
      });
  if (hit == geometry::TriangleBvh::kNoTriangle) return std::nullopt;
  const geometry::TriangleCorners& t = triangles().corners(hit);
  const Vec3 there = from + least_m * direction;
  const Vec3 point = geometry::closest_on_triangle(there, t);
  return SurfacePoint{start_m + least_m, point, unit_or(there - point, -direction), false};
}

std::optional<SurfacePoint> BodySurface::cast_sphere(const Vec3& center_m, double radius_m, const Vec3& direction,
                                                     double limit_m) const {
  const double near_m = contains(center_m) ? kMiss : radius_m;
  if (std::optional<SurfacePoint> near = closest(center_m, near_m); near && near->distance_m <= radius_m) {
    near->distance_m = 0;
    near->at_start = true;
    return near;
  }
  if (is_plane()) return ray_to_plane(center_m, direction, limit_m, radius_m);
  if (!shape_->surface) return ray_to_balls(center_m, direction, limit_m, radius_m);
  if (radius_m > 0) return sphere_to_triangles(center_m, radius_m, direction, limit_m);
  return ray_to_triangles(center_m, direction, limit_m);
}

bool BodySurface::overlaps_ball(const Vec3& center_m, double radius_m) const {
  if (is_plane()) return shape_->plane_normal.dot(center_m) - shape_->plane_offset_m <= radius_m;
  if (shape_->surface) {
    if (box_.squared_distance(center_m) > radius_m * radius_m) return false;
    const double bound2 = std::nextafter(radius_m * radius_m, kMiss);
    return triangles().closest(center_m, bound2).triangle != geometry::TriangleBvh::kNoTriangle || contains(center_m);
  }
  bool met = false;
  walk_balls(
      tree_, [&](const BallTree::Node& node) { return (center_m - node.center_m).norm() - node.radius_m - radius_m; },
      [&] { return met ? -kMiss : 0.0; },
      [&](std::uint32_t i) { met |= (center_m - balls_m_[i].center_m).norm() <= balls_m_[i].radius_m + radius_m; });
  return met;
}

bool BodySurface::overlaps_box(const Mat3& rotation, const Vec3& offset_m, const Vec3& half_extents_m) const {
  const Vec3 center_of_box = rotation.transpose() * -offset_m;
  if (is_plane()) {
    const double reach_m = half_extents_m.dot((rotation * shape_->plane_normal).cwiseAbs());
    return shape_->plane_normal.dot(center_of_box) - shape_->plane_offset_m <= reach_m;
  }
  if (shape_->surface) {
    bool met = false;
    // The box around the query box, in the body frame, for a first test.
    const Vec3 reach = rotation.transpose().cwiseAbs() * half_extents_m * (1 + 1e-12);
    const Bounds around{center_of_box - reach, center_of_box + reach};
    walk(
        triangles(),
        [&](const Vec3& low, const Vec3& high) {
          return (low.array() <= around.high.array()).all() && (high.array() >= around.low.array()).all() ? 0.0 : kMiss;
        },
        [] { return 0.0; },
        [&](std::uint32_t place) {
          const geometry::TriangleCorners& t = triangles().corners_at(place);
          met = triangle_meets_box({rotation * t[0] + offset_m, rotation * t[1] + offset_m, rotation * t[2] + offset_m},
                                   half_extents_m);
          return met;
        });
    return met || contains(center_of_box);
  }
  bool met = false;
  const auto gap_m = [&](const Vec3& center, double radius_m) {
    const Vec3 beyond = ((rotation * center + offset_m).cwiseAbs() - half_extents_m).cwiseMax(0.0);
    return beyond.norm() - radius_m;
  };
  walk_balls(
      tree_, [&](const BallTree::Node& node) { return gap_m(node.center_m, node.radius_m); },
      [&] { return met ? -kMiss : 0.0; },
      [&](std::uint32_t i) { met |= gap_m(balls_m_[i].center_m, balls_m_[i].radius_m) <= 0; });
  return met;
}

std::optional<SurfacePoint> BodySurface::closest_of_triangles(const Vec3& point, double limit_m) const {
  const double bound2 = std::nextafter(limit_m * limit_m, kMiss);
  const geometry::TriangleBvh::Closest found = triangles().closest(point, bound2);
  if (found.triangle == geometry::TriangleBvh::kNoTriangle) return std::nullopt;
  const double distance_m = std::sqrt(found.squared_distance_m2);
  const bool inside = contains(point);
  const Vec3 away = inside ? Vec3(found.point_m - point) : Vec3(point - found.point_m);
  const Vec3 face = unit_or(normal_of(triangles().corners(found.triangle)), Vec3::UnitZ());
  return SurfacePoint{inside ? -distance_m : distance_m, found.point_m, unit_or(away, face), false};
}

SurfacePoint BodySurface::closest_of_balls(const Vec3& point) const {
  double least_m = kMiss;
  std::uint32_t nearest = 0;
  walk_balls(
      tree_, [&](const BallTree::Node& node) { return (point - node.center_m).norm() - node.radius_m; },
      [&] { return least_m; },
      [&](std::uint32_t i) {
        const double distance_m = (point - balls_m_[i].center_m).norm() - balls_m_[i].radius_m;
        if (distance_m < least_m || (distance_m == least_m && i < nearest)) {
          least_m = distance_m;
          nearest = i;
        }
      });
  const Sphere& ball = balls_m_[nearest];
  const Vec3 normal = unit_or(point - ball.center_m, Vec3::UnitZ());
  return {least_m, ball.center_m + ball.radius_m * normal, normal, false};
}

std::optional<SurfacePoint> BodySurface::closest(const Vec3& point, double limit_m) const {
  if (is_plane()) {
    const Vec3& normal = shape_->plane_normal;
    const double distance_m = normal.dot(point) - shape_->plane_offset_m;
    if (std::abs(distance_m) > limit_m) return std::nullopt;
    return SurfacePoint{distance_m, point - distance_m * normal, normal, false};
  }
  if (shape_->surface) return closest_of_triangles(point, limit_m);
  const SurfacePoint found = closest_of_balls(point);
  if (std::abs(found.distance_m) > limit_m) return std::nullopt;
  return found;
}

}  // namespace poise::query
