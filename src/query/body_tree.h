// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "geometry/primitives/bounds.h"
#include "query/triangle_queries.h"

namespace poise::query {

/// A binary tree of boxes over boxes. Invariant: the box of a node contains all boxes below it, and each box is below
/// exactly one leaf. Any thread may read.
class BodyTree {
 public:
  /// Splits by halving along the longest side of the box around the middles. Deterministic.
  void build(std::span<const geometry::Bounds> boxes);
  /// Refits the tree to the same boxes after they moved; its structure stays. Returns false, and the tree must be
  /// rebuilt, if the number of boxes changed or the nodes have become so large that a new tree is better.
  bool refit(std::span<const geometry::Bounds> boxes);

  /// Calls visit(index of a box), nearer nodes first. `bound(low, high)` returns a lower bound for everything in the
  /// box, or kMiss; nodes with a bound above limit() are skipped.
  template <class Bound, class Limit, class Visit>
  void walk(Bound&& bound, Limit&& limit, Visit&& visit) const;

 private:
  struct Node {
    geometry::Bounds box;
    std::uint32_t begin = 0, end = 0;  ///< range in order_ of the boxes below
    std::uint32_t right = 0;           ///< second child; the first one is the next node; 0 for a leaf
  };
  [[nodiscard]] double extent() const;

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;  ///< box indices in the order of the leaves
  double built_extent_ = 0;
};

template <class Bound, class Limit, class Visit>
void BodyTree::walk(Bound&& bound, Limit&& limit, Visit&& visit) const {
  if (nodes_.empty()) return;
  struct Waiting {
    double least;
    std::uint32_t node;
  };
  // Ranges are halved each time: at most 32 levels, with one node a level on the stack.
  std::array<Waiting, 64> waiting;
  std::size_t count = 0;
  const auto look = [&](std::uint32_t at) { return Waiting{bound(nodes_[at].box.low, nodes_[at].box.high), at}; };
  waiting[count++] = look(0);
  while (count > 0) {
    const Waiting top = waiting[--count];
    if (!(top.least <= limit()) || top.least == kMiss) continue;
    const Node& node = nodes_[top.node];
    if (node.right == 0) {
      for (std::uint32_t place = node.begin; place < node.end; ++place) visit(order_[place]);
      continue;
    }
    Waiting near = look(top.node + 1);
    Waiting far = look(node.right);
    if (far.least < near.least) std::swap(near, far);
    waiting[count++] = far;
    waiting[count++] = near;
  }
}

}  // namespace poise::query
