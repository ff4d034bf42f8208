// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "poise/sphere_tree.h"

namespace poise::geometry {

/// A binary tree of bounding balls over a set of balls. Invariant: the ball of a node contains all balls below it, and
/// each ball is below exactly one leaf. Immutable once made; any thread may read.
class BallTree {
 public:
  struct Node {
    Vec3 center_m = Vec3::Zero();
    double radius_m = 0;
    std::uint32_t begin = 0, end = 0;  ///< range in order() of the balls below
    std::uint32_t right = 0;           ///< second child; the first one is the next node; 0 for a leaf
    [[nodiscard]] bool leaf() const { return right == 0; }
  };

  BallTree() = default;
  /// Splits by halving along the longest side of the box around the centres. Deterministic. Centres and radii must be
  /// finite.
  explicit BallTree(std::span<const Sphere> balls);

  /// Nodes, the root first; empty without balls.
  [[nodiscard]] std::span<const Node> nodes() const { return nodes_; }
  /// Indices of the balls in the order of the leaves.
  [[nodiscard]] std::span<const std::uint32_t> order() const { return order_; }

  /// Calls visit(index of a ball) for a superset of the balls that meet a segment, until visit returns true.
  template <class Visit>
  bool any_along(const Vec3& from, const Vec3& to, Visit&& visit) const;

 private:
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

/// Distance from a point to a segment, in metres.
double distance_to_segment_m(const Vec3& point, const Vec3& from, const Vec3& to);

template <class Visit>
bool BallTree::any_along(const Vec3& from, const Vec3& to, Visit&& visit) const {
  std::vector<std::uint32_t> waiting;
  if (!nodes_.empty()) waiting.push_back(0);
  while (!waiting.empty()) {
    const std::uint32_t at = waiting.back();
    waiting.pop_back();
    const Node& node = nodes_[at];
    if (distance_to_segment_m(node.center_m, from, to) > node.radius_m) continue;
    if (!node.leaf()) {
      waiting.push_back(node.right);
      waiting.push_back(at + 1);
      continue;
    }
    for (std::uint32_t place = node.begin; place < node.end; ++place) {
      if (visit(order_[place])) return true;
    }
  }
  return false;
}

}  // namespace poise::geometry
