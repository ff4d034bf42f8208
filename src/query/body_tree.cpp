// SPDX-License-Identifier: MIT
#include "query/body_tree.h"

#include <algorithm>
#include <numeric>

namespace poise::query {
namespace {

constexpr std::uint32_t kBoxesOfLeaf = 4;
/// A refitted tree is rebuilt when the sum of its nodes' sides has grown by this factor. Chosen.
constexpr double kOutgrown = 1.5;

}  // namespace

double BodyTree::extent() const {
  double sum = 0;
  for (const Node& node : nodes_) sum += (node.box.high - node.box.low).sum();
  return sum;
}

void BodyTree::build(std::span<const geometry::Bounds> boxes) {
  nodes_.clear();
  order_.resize(boxes.size());
  std::iota(order_.begin(), order_.end(), 0U);
  struct Part {
    std::uint32_t begin, end;
    std::uint32_t parent;  ///< 1 + the node whose second child this is; 0 for the root and for first children
  };
  std::vector<Part> waiting;
  if (!boxes.empty()) waiting.push_back({0, static_cast<std::uint32_t>(boxes.size()), 0});
  while (!waiting.empty()) {
    const Part part = waiting.back();
    waiting.pop_back();
    const auto at = static_cast<std::uint32_t>(nodes_.size());
    if (part.parent != 0) nodes_[part.parent - 1].right = at;
    const std::span<std::uint32_t> which = std::span(order_).subspan(part.begin, part.end - part.begin);
    Node node;
    node.begin = part.begin;
    node.end = part.end;
    geometry::Bounds middles;
    for (const std::uint32_t i : which) {
      node.box.add(boxes[i]);
      middles.add(boxes[i].center());
    }
    nodes_.push_back(node);
    if (which.size() <= kBoxesOfLeaf) continue;
    Eigen::Index axis = 0;
    (middles.high - middles.low).maxCoeff(&axis);
    const std::uint32_t middle = part.begin + (part.end - part.begin) / 2;
    std::nth_element(which.begin(), which.begin() + (middle - part.begin), which.end(),
                     [&](std::uint32_t i, std::uint32_t j) {
                       const double x = boxes[i].low[axis] + boxes[i].high[axis];
                       const double y = boxes[j].low[axis] + boxes[j].high[axis];
                       return x < y || (x == y && i < j);
                     });
    // The first half is on top of the stack, so that its node follows this one.
    waiting.push_back({middle, part.end, at + 1});
    waiting.push_back({part.begin, middle, 0});
  }
  built_extent_ = extent();
}

bool BodyTree::refit(std::span<const geometry::Bounds> boxes) {
  if (boxes.size() != order_.size() || nodes_.empty()) return false;
  for (std::size_t at = nodes_.size(); at-- > 0;) {
    Node& node = nodes_[at];
    node.box = {};
    if (node.right == 0) {
      for (std::uint32_t place = node.begin; place < node.end; ++place) node.box.add(boxes[order_[place]]);
    } else {
      node.box.add(nodes_[at + 1].box);
      node.box.add(nodes_[node.right].box);
    }
  }
  return extent() <= kOutgrown * built_extent_;
}

}  // namespace poise::query
