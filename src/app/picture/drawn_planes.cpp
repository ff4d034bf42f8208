// SPDX-License-Identifier: MIT
#include "app/picture/drawn_planes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace poise::io {
namespace {

constexpr double kSteep = 0.5;       // cosine of the angle with upward below which a plane is a wall
constexpr double kWallHeight = 0.1;  // of a wall's length: chosen, the tray is seen and hides nothing
constexpr double kWithoutEnd = 1e6;  // metres

/// The part of a convex polygon with normal . x >= offset_m.
std::vector<Vec3> clipped(const std::vector<Vec3>& polygon, const Vec3& normal, double offset_m) {
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& a = polygon[i];
    const Vec3& b = polygon[(i + 1) % polygon.size()];
    const double of_a = normal.dot(a) - offset_m;
    const double of_b = normal.dot(b) - offset_m;
    if (of_a >= 0) kept.push_back(a);
    if ((of_a >= 0) != (of_b >= 0)) kept.emplace_back(a + of_a / (of_a - of_b) * (b - a));
  }
  return kept;
}

std::vector<Vec3> wall_of(const std::vector<DrawnPlane>& planes, std::size_t which, const Vec3& up) {
  const DrawnPlane& wall = planes[which];
  const Vec3 along = up.cross(wall.normal).normalized();
  const Vec3 upward = wall.normal.cross(along);
  const Vec3 middle = wall.offset_m * wall.normal;
  std::vector<Vec3> polygon;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    polygon.emplace_back(middle + kWithoutEnd * (x * along + y * upward));
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (i != which) polygon = clipped(polygon, planes[i].normal, planes[i].offset_m);
  }
  if (polygon.empty()) return {};
  const auto [low, high] = std::ranges::minmax(polygon, {}, [&](const Vec3& p) { return along.dot(p); });
  const double length_m = along.dot(high - low);
  const Vec3 foot = std::ranges::min(polygon, {}, [&](const Vec3& p) { return upward.dot(p); });
  if (length_m > kWithoutEnd || upward.dot(foot - middle) <= -0.5 * kWithoutEnd) return {};
  return clipped(polygon, -upward, -(upward.dot(foot) + kWallHeight * length_m));
}

}  // namespace

std::vector<DrawnPlane> drawn_planes(const DrawnFrame& frame, std::span<const capture::CapturedShape> shapes) {
  std::vector<DrawnPlane> planes;
  for (const DrawnBody& body : frame.bodies) {
    const capture::CapturedShape& shape = shapes[body.shape];
    if (!shape.plane) continue;
    DrawnPlane& plane = planes.emplace_back();
    plane.normal = body.pose.orientation * Vec3(shape.normal[0], shape.normal[1], shape.normal[2]);
    plane.offset_m = shape.offset_m + plane.normal.dot(body.pose.position_m);
    plane.ground = plane.normal.dot(frame.up) > kSteep;
  }
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (!planes[i].ground) planes[i].corners = wall_of(planes, i, frame.up);
  }
  std::erase_if(planes, [](const DrawnPlane& plane) { return !plane.ground && plane.corners.size() < 3; });
  return planes;
}

std::optional<double> distance_along(const DrawnPlane& plane, const Vec3& from_m, const Vec3& ray) {
  const double slope = plane.normal.dot(ray);
  const double t = (plane.offset_m - plane.normal.dot(from_m)) / slope;
  if (slope >= 0 || !(t > 0)) return std::nullopt;
  if (plane.ground) return t;
  const Vec3 hit = from_m + t * ray;
  double side = 0;
  for (std::size_t i = 0; i < plane.corners.size(); ++i) {
    const Vec3& a = plane.corners[i];
    const Vec3& b = plane.corners[(i + 1) % plane.corners.size()];
    const double turn = plane.normal.dot((b - a).cross(hit - a));
    if (turn * side < 0) return std::nullopt;
    if (turn != 0) side = turn;
  }
  return t;
}

}  // namespace poise::io
