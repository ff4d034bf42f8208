// SPDX-License-Identifier: MIT
#include "geometry/mesh/ear_clipping.h"

#include <algorithm>

namespace poise::geometry {
namespace {

using Point2 = Eigen::Vector2d;

double doubled_area(const Point2& a, const Point2& b, const Point2& c) {
  return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
}

bool inside_or_on(const Point2& p, const Point2& a, const Point2& b, const Point2& c) {
  return doubled_area(a, b, p) >= 0 && doubled_area(b, c, p) >= 0 && doubled_area(c, a, p) >= 0;
}

/// Projects the corners onto the coordinate plane with the largest projected area; the orientation stays
/// counter-clockwise.
std::vector<Point2> flatten(std::span<const Vec3> vertices_m, std::span<const std::uint32_t> corners) {
  Vec3 normal = Vec3::Zero();
  const Vec3& near = vertices_m[corners[0]];
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = vertices_m[corners[i]] - near;
    const Vec3 b = vertices_m[corners[(i + 1) % corners.size()]] - near;
    normal += a.cross(b);
  }
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  std::vector<Point2> points;
  for (const std::uint32_t corner : corners) {
    const Vec3& p = vertices_m[corner];
    points.emplace_back(normal[axis] < 0 ? -p[u] : p[u], p[v]);
  }
  return points;
}

}  // namespace

void triangulate_polygon(std::span<const Vec3> vertices_m, std::span<const std::uint32_t> corners,
                         std::vector<std::array<std::uint32_t, 3>>& triangles) {
  if (corners.size() < 3) return;
  if (corners.size() == 3) {
    triangles.push_back({corners[0], corners[1], corners[2]});
    return;
  }
  const std::vector<Point2> points = flatten(vertices_m, corners);
  std::vector<std::size_t> left(corners.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  while (left.size() > 3) {
    const std::size_t n = left.size();
    std::size_t ear = 0;  // a polygon without an ear crosses itself; then any corner may be cut
    bool found = false;
    for (std::size_t i = 0; i < n && !found; ++i) {
      const Point2& a = points[left[(i + n - 1) % n]];
      const Point2& b = points[left[i]];
      const Point2& c = points[left[(i + 1) % n]];
      if (!(doubled_area(a, b, c) > 0)) continue;
      const bool blocked = std::ranges::any_of(left, [&](std::size_t other) {
        const Point2& p = points[other];
        return p != a && p != b && p != c && inside_or_on(p, a, b, c);
      });
      if (!blocked) {
        ear = i;
        found = true;
      }
    }
    triangles.push_back({corners[left[(ear + n - 1) % n]], corners[left[ear]], corners[left[(ear + 1) % n]]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  triangles.push_back({corners[left[0]], corners[left[1]], corners[left[2]]});
}

}  // namespace poise::geometry
