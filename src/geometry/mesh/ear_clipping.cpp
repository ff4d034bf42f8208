// SPDX-License-Identifier: MIT
#include "geometry/mesh/ear_clipping.h"

#include <algorithm>
#include <utility>

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

/// A polygon from which ears are cut, the first in the order of its corners at each turn. A corner whose triangle has
/// another corner inside stays blocked until that one is cut or a neighbour changes, so that each triangle is compared
/// with each corner once: 3 n^2 comparisons at most, where looking anew at each turn takes n^3.
class EarClipper {
 public:
  EarClipper(std::vector<Point2> points, std::uint64_t& tests_left)
      : points_(std::move(points)), states_(points_.size()), tests_left_(tests_left) {
    for (std::size_t i = 0; i < points_.size(); ++i) left_.push_back(static_cast<std::uint32_t>(i));
  }
  [[nodiscard]] std::size_t size() const { return left_.size(); }
  /// The corners before, at and after place `i` of those that are left.
  [[nodiscard]] std::array<std::uint32_t, 3> triangle(std::size_t i) const {
    const std::size_t n = left_.size();
    return {left_[(i + n - 1) % n], left_[i], left_[(i + 1) % n]};
  }
  /// The place of the first ear. A polygon without an ear crosses itself; then any corner may be cut.
  std::size_t first_ear() {
    for (std::size_t i = 0; i < left_.size(); ++i) {
      if (is_ear(i)) return i;
    }
    return 0;
  }
  void cut(std::size_t i) {
    const std::array<std::uint32_t, 3> corners = triangle(i);
    states_[corners[0]] = {};
    states_[corners[2]] = {};
    states_[corners[1]].cut = true;
    left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  [[nodiscard]] bool exhausted() const { return tests_left_ == 0; }

 private:
  struct State {
    std::uint32_t next = 0;  ///< corners below it are outside the triangle of this one
    bool known = false;
    bool turns = false;  ///< to the left, as an ear does
    bool cut = false;
  };

  bool is_ear(std::size_t i) {
    const std::array<std::uint32_t, 3> corners = triangle(i);
    State& state = states_[corners[1]];
    const Point2& a = points_[corners[0]];
    const Point2& b = points_[corners[1]];
    const Point2& c = points_[corners[2]];
    if (!state.known) state = {0, true, doubled_area(a, b, c) > 0, false};
    count(1);
    if (!state.turns) return false;
    for (; state.next < points_.size() && !exhausted(); ++state.next) {
      if (states_[state.next].cut) continue;
      const Point2& p = points_[state.next];
      if (p != a && p != b && p != c && inside_or_on(p, a, b, c)) return false;
      count(1);
    }
    return true;
  }
  void count(std::uint64_t tests) { tests_left_ -= std::min(tests, tests_left_); }

  std::vector<Point2> points_;
  std::vector<State> states_;
  std::vector<std::uint32_t> left_;
  std::uint64_t& tests_left_;
};

}  // namespace

bool triangulate_polygon(std::span<const Vec3> vertices_m, std::span<const std::uint32_t> corners,
                         std::uint64_t& tests_left, std::vector<std::array<std::uint32_t, 3>>& triangles) {
  if (corners.size() < 3) return true;
  if (corners.size() == 3) {
    triangles.push_back({corners[0], corners[1], corners[2]});
    return true;
  }
  constexpr std::size_t kMostCorners = 1'000'000;  // whose square is a number still
  if (corners.size() > kMostCorners || corners.size() * corners.size() / 2 > tests_left) return false;
  EarClipper polygon(flatten(vertices_m, corners), tests_left);
  for (;;) {
    const std::size_t ear = polygon.size() > 3 ? polygon.first_ear() : 1;
    if (polygon.exhausted()) return false;
    const std::array<std::uint32_t, 3> cut = polygon.triangle(ear);
    triangles.push_back({corners[cut[0]], corners[cut[1]], corners[cut[2]]});
    if (polygon.size() == 3) return true;
    polygon.cut(ear);
  }
}

}  // namespace poise::geometry
