// SPDX-License-Identifier: MIT
#include "geometry/triangle_bvh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace poise::geometry {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;
/// A cluster acts as a dipole from this many of its reaches on (the paper's choice); errors reached 0.2 on a thin bowl.
constexpr double kDipoleFrom = 2.0;
/// A winding number is a whole one; one that is reckoned within this of a half is summed up exactly instead.
constexpr double kUnsure = 0.2;

Vec3 closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length2 = along.squaredNorm();
  if (!(length2 > 0)) return a;
  return a + std::clamp((p - a).dot(along) / length2, 0.0, 1.0) * along;
}

Vec3 closest_on_triangle(const Vec3& p, const std::array<Vec3, 3>& t) {
  const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double normal2 = normal.squaredNorm();
  bool above = normal2 > 0;
  for (std::size_t i = 0; i < 3 && above; ++i) above = normal.cross(t[(i + 1) % 3] - t[i]).dot(p - t[i]) >= 0;
  if (above) return p - (p - t[0]).dot(normal) / normal2 * normal;
  Vec3 best = closest_on_segment(p, t[0], t[1]);
  for (std::size_t i = 1; i < 3; ++i) {
    const Vec3 candidate = closest_on_segment(p, t[i], t[(i + 1) % 3]);
    if ((candidate - p).squaredNorm() < (best - p).squaredNorm()) best = candidate;
  }
  return best;
}

/// Share of the sphere around p that a triangle covers, signed, in (-1/2, 1/2].
double winding_of_triangle(const Vec3& p, const std::array<Vec3, 3>& t) {
  const Vec3 a = t[0] - p;
  const Vec3 b = t[1] - p;
  const Vec3 c = t[2] - p;
  const double la = a.norm();
  const double lb = b.norm();
  const double lc = c.norm();
  const double above = a.dot(b.cross(c));
  const double below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return std::atan2(above, below) / (2 * std::numbers::pi);
}

}  // namespace

TriangleBvh::TriangleBvh(const TriangleMesh& mesh) {
  corners_m_.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) corners_m_.push_back({mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]});
  if (!corners_m_.empty()) build(0, static_cast<std::uint32_t>(corners_m_.size()));
}

void TriangleBvh::sum_up(Node& node) const {
  double area_sum = 0;
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    const auto& t = corners_m_[i];
    for (const Vec3& corner : t) node.box.add(corner);
    const Vec3 area = 0.5 * (t[1] - t[0]).cross(t[2] - t[0]);
    node.area_normal_m2 += area;
    node.middle_m += area.norm() * (t[0] + t[1] + t[2]) / 3;
    area_sum += area.norm();
  }
  node.middle_m = area_sum > 0 ? Vec3(node.middle_m / area_sum) : node.box.center();
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    for (const Vec3& corner : corners_m_[i]) node.reach_m = std::max(node.reach_m, (corner - node.middle_m).norm());
  }
}

std::uint32_t TriangleBvh::build(std::uint32_t first, std::uint32_t count) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  Node node;
  node.first = first;
  node.count = count;
  sum_up(node);
  nodes_.push_back(node);
  if (count <= kLeafTriangles) return index;
  int axis = 0;
  (node.box.high - node.box.low).maxCoeff(&axis);
  const auto begin = corners_m_.begin() + first;
  // Stable, so that equal middles keep the order of the file.
  std::stable_sort(begin, begin + count, [axis](const auto& s, const auto& t) {
    return s[0][axis] + s[1][axis] + s[2][axis] < t[0][axis] + t[1][axis] + t[2][axis];
  });
  build(first, count / 2);
  const std::uint32_t right = build(first + count / 2, count - count / 2);
  nodes_[index].right = right;
  return index;
}

void TriangleBvh::search(std::uint32_t index, const Vec3& point, Closest& best) const {
  const Node& node = nodes_[index];
  if (node.right == 0) {
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Vec3 candidate = closest_on_triangle(point, corners_m_[i]);
      const double d2 = (candidate - point).squaredNorm();
      if (d2 < best.squared_distance_m2) best = {d2, candidate};
    }
    return;
  }
  std::uint32_t near = index + 1;
  std::uint32_t far = node.right;
  double near_d2 = nodes_[near].box.squared_distance(point);
  double far_d2 = nodes_[far].box.squared_distance(point);
  if (far_d2 < near_d2) {
    std::swap(near, far);
    std::swap(near_d2, far_d2);
  }
  if (near_d2 < best.squared_distance_m2) search(near, point, best);
  if (far_d2 < best.squared_distance_m2) search(far, point, best);
}

TriangleBvh::Closest TriangleBvh::closest(const Vec3& point, double squared_bound_m2) const {
  Closest best;
  best.squared_distance_m2 = squared_bound_m2;
  if (!nodes_.empty()) search(0, point, best);
  return best;
}

double TriangleBvh::winding_below(std::uint32_t index, const Vec3& point) const {
  const Node& node = nodes_[index];
  const Vec3 away = node.middle_m - point;
  const double distance2 = away.squaredNorm();
  if (distance2 > kDipoleFrom * kDipoleFrom * node.reach_m * node.reach_m) {
    return node.area_normal_m2.dot(away) / (4 * std::numbers::pi * distance2 * std::sqrt(distance2));
  }
  if (node.right != 0) return winding_below(index + 1, point) + winding_below(node.right, point);
  double sum = 0;
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) sum += winding_of_triangle(point, corners_m_[i]);
  return sum;
}

double TriangleBvh::winding_number(const Vec3& point) const { return nodes_.empty() ? 0.0 : winding_below(0, point); }

bool TriangleBvh::inside(const Vec3& point) const {
  double winding = std::abs(winding_number(point));
  if (std::abs(winding - 0.5) < kUnsure) {
    winding = 0;
    for (const auto& t : corners_m_) winding += winding_of_triangle(point, t);
    winding = std::abs(winding);
  }
  return winding > 0.5;
}

double TriangleBvh::outside_distance_m(const Vec3& point) const {
  return inside(point) ? 0.0 : std::sqrt(closest(point).squared_distance_m2);
}

double TriangleBvh::signed_distance_m(const Vec3& point) const {
  const double distance_m = std::sqrt(closest(point).squared_distance_m2);
  return inside(point) ? -distance_m : distance_m;
}

}  // namespace poise::geometry
