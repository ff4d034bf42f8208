// SPDX-License-Identifier: MIT
#include "geometry/bvh/ball_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace poise::geometry {
namespace {

constexpr std::uint32_t kBallsOfLeaf = 2;
// More than the rounding of a distance in double.
constexpr double kWiden = 1 + 1e-12;

/// Sets the node's ball: about the middle of the box around the given balls.
void enclose(std::span<const Sphere> balls, std::span<const std::uint32_t> which, BallTree::Node& node) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Vec3 low = Vec3::Constant(kFar);
  Vec3 high = Vec3::Constant(-kFar);
  for (const std::uint32_t i : which) {
    low = low.cwiseMin(balls[i].center_m - Vec3::Constant(balls[i].radius_m));
    high = high.cwiseMax(balls[i].center_m + Vec3::Constant(balls[i].radius_m));
  }
  node.center_m = 0.5 * (low + high);
  for (const std::uint32_t i : which) {
    const double reach_m = (balls[i].center_m - node.center_m).norm() + balls[i].radius_m;
    node.radius_m = std::max(node.radius_m, reach_m * kWiden);
  }
}

Eigen::Index longest_axis(std::span<const Sphere> balls, std::span<const std::uint32_t> which) {
  Vec3 low = balls[which.front()].center_m;
  Vec3 high = low;
  for (const std::uint32_t i : which) {
    low = low.cwiseMin(balls[i].center_m);
    high = high.cwiseMax(balls[i].center_m);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  return axis;
}

}  // namespace

BallTree::BallTree(std::span<const Sphere> balls) : order_(balls.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
  struct Part {
    std::uint32_t begin, end;
    std::uint32_t parent;  ///< node whose second child this is; 0 for the root and for first children
  };
  std::vector<Part> waiting;
  if (!balls.empty()) waiting.push_back({0, static_cast<std::uint32_t>(balls.size()), 0});
  while (!waiting.empty()) {
    const Part part = waiting.back();
    waiting.pop_back();
    const auto at = static_cast<std::uint32_t>(nodes_.size());
    if (part.parent != 0) nodes_[part.parent - 1].right = at;
    const std::span<std::uint32_t> which = std::span(order_).subspan(part.begin, part.end - part.begin);
    Node node;
    node.begin = part.begin;
    node.end = part.end;
    enclose(balls, which, node);
    nodes_.push_back(node);
    if (which.size() <= kBallsOfLeaf) continue;
    const Eigen::Index axis = longest_axis(balls, which);
    const std::uint32_t middle = part.begin + (part.end - part.begin) / 2;
    std::nth_element(which.begin(), which.begin() + (middle - part.begin), which.end(),
                     [&](std::uint32_t i, std::uint32_t j) {
                       const double x = balls[i].center_m[axis];
                       const double y = balls[j].center_m[axis];
                       return x < y || (x == y && i < j);
                     });
    // The first half is on top of the stack, so that its node follows this one.
    waiting.push_back({middle, part.end, at + 1});
    waiting.push_back({part.begin, middle, 0});
  }
}

double distance_to_segment_m(const Vec3& point, const Vec3& from, const Vec3& to) {
  const Vec3 along = to - from;
  const double length2 = along.squaredNorm();
  const double share = length2 > 0 ? std::clamp((point - from).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (point - from - share * along).norm();
}

}  // namespace poise::geometry
