// SPDX-License-Identifier: MIT
#include "geometry/tree_surface.h"

#include <algorithm>
#include <cmath>

namespace poise::geometry {
namespace {

using Vec2 = Eigen::Vector2d;

/// Area and first moment in a plane, about the disc's centre.
struct FlatSum {
  double area = 0;
  Vec2 moment = Vec2::Zero();

  /// The triangle from the centre to a and b.
  void add_triangle(const Vec2& a, const Vec2& b) {
    const double part = 0.5 * (a.x() * b.y() - a.y() * b.x());
    area += part;
    moment += part / 3 * (a + b);
  }
  /// The sector of the disc between the directions of a and b, by the shorter way.
  void add_sector(const Vec2& a, const Vec2& b, double radius) {
    const double angle = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    area += 0.5 * radius * radius * angle;
    const double la = a.norm();
    const double lb = b.norm();
    if (!(la > 0 && lb > 0)) return;
    // The integral of a direction over angles is the difference of the directions at the ends, a quarter turn back.
    const Vec2 turned(b.y() / lb - a.y() / la, a.x() / la - b.x() / lb);
    moment += radius * radius * radius / 3 * turned;
  }
  /// The part of the disc that the triangle from the centre to a and b has.
  void add_edge(const Vec2& a, const Vec2& b, double radius) {
    const Vec2 along = b - a;
    const double length2 = along.squaredNorm();
    if (!(length2 > 0)) return;
    const double half = -a.dot(along) / length2;
    const double under = half * half - (a.squaredNorm() - radius * radius) / length2;
    if (!(under > 0)) {
      add_sector(a, b, radius);
      return;
    }
    const double from = std::clamp(half - std::sqrt(under), 0.0, 1.0);
    const double to = std::clamp(half + std::sqrt(under), 0.0, 1.0);
    if (!(from < to)) {
      add_sector(a, b, radius);
      return;
    }
    const Vec2 entry = a + from * along;
    const Vec2 exit = a + to * along;
    if (from > 0) add_sector(a, entry, radius);
    add_triangle(entry, exit);
    if (to < 1) add_sector(exit, b, radius);
  }
};

struct BallSurface {
  double area_m2 = 0;
  Vec3 area_normal_m2 = Vec3::Zero();
  Vec3 moment_m3 = Vec3::Zero();
};

std::int16_t as_share(double value) { return static_cast<std::int16_t>(std::lround(32767 * std::clamp(value, -1.0, 1.0))); }

NodeSurface stored(const BallSurface& sum, double radius_m) {
  NodeSurface surface;
  surface.area_m2 = static_cast<float>(sum.area_m2);
  if (!(sum.area_m2 > 0)) return {};
  const Vec3 mean = sum.area_normal_m2 / sum.area_m2;
  for (std::size_t axis = 0; axis < 3; ++axis) surface.normal[axis] = as_share(mean[static_cast<Eigen::Index>(axis)]);
  // Along the normal as it is stored, so that a reader's direction is the one that was measured along.
  const Vec3 way(surface.normal[0], surface.normal[1], surface.normal[2]);
  const double length = way.norm();
  if (length > 0) surface.offset = as_share((sum.moment_m3 / sum.area_m2).dot(way) / length / radius_m);
  return surface;
}

}  // namespace

SurfacePiece triangle_in_ball(const TriangleCorners& t, const Vec3& normal, const Sphere& ball) {
  const std::array<Vec3, 3> from{t[0] - ball.center_m, t[1] - ball.center_m, t[2] - ball.center_m};
  const double radius2 = ball.radius_m * ball.radius_m;
  if (std::ranges::all_of(from, [&](const Vec3& corner) { return corner.squaredNorm() <= radius2; })) {
    const double area = 0.5 * (from[1] - from[0]).cross(from[2] - from[0]).norm();
    return {area, area / 3 * (from[0] + from[1] + from[2])};
  }
  const double height = normal.dot(from[0]);
  const double disc2 = radius2 - height * height;
  if (!(disc2 > 0)) return {};
  const Vec3 u = normal.unitOrthogonal();
  const Vec3 v = normal.cross(u);
  FlatSum sum;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& a = from[i];
    const Vec3& b = from[(i + 1) % 3];
    sum.add_edge({a.dot(u), a.dot(v)}, {b.dot(u), b.dot(v)}, std::sqrt(disc2));
  }
  if (!(sum.area > 0)) return {};
  return {sum.area, sum.moment.x() * u + sum.moment.y() * v + sum.area * height * normal};
}

void measure_surfaces(SphereTree& tree, const TriangleBvh& bvh, parallel::Executor& executor) {
  parallel::parallel_for(executor, tree.node_count(), 1, [&](std::size_t begin, std::size_t end, int) {
    std::vector<std::uint32_t> near;
    for (std::size_t node = begin; node < end; ++node) {
      const Sphere ball = tree.sphere(static_cast<NodeIndex>(node));
      near.clear();
      bvh.triangles_near(ball.center_m, ball.radius_m, near);
      BallSurface sum;
      for (const std::uint32_t triangle : near) {
        const Vec3 normal = bvh.triangle_normal(triangle);
        if (normal.isZero(0)) continue;
        const SurfacePiece piece = triangle_in_ball(bvh.corners(triangle), normal, ball);
        sum.area_m2 += piece.area_m2;
        sum.area_normal_m2 += piece.area_m2 * normal;
        sum.moment_m3 += piece.moment_m3;
      }
      tree.surface[node] = stored(sum, ball.radius_m);
    }
  });
}

}  // namespace poise::geometry
