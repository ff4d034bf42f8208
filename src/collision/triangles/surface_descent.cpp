// SPDX-License-Identifier: MIT
#include "collision/triangles/surface_descent.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace poise::collision {
namespace {

using geometry::BvhNode;
using geometry::TriangleBvh;

// Boxes are placed with some twenty roundings of coordinates no larger than both meshes and their distance, and so are
// the corners of triangles; a height over a plane, or over a side per length, has as many again.
constexpr double kRounding = 4e-6;
constexpr double kTriangleRounding = 8e-6;
// Of two nodes the larger is split alone where it is by this larger than the other.
constexpr float kMuchLarger = 2;

bool is_triangle(std::uint32_t node) { return (node & BvhNode::kTriangle) != 0; }

}  // namespace

// What takes the place of one of the two nodes: its children, or itself.
struct SurfaceDescent::Side {
  const TriangleBvh& bvh;
  const Child child;
  const BvhNode* const parent;
  const std::uint32_t node;

  Side(const ShapeSurface& surface, Child waiting)
      : bvh(surface.bvh),
        child(waiting),
        parent(waiting == kRoot ? nullptr : &bvh.nodes()[waiting >> 2U]),
        node(waiting == kRoot ? 0 : parent->child[waiting & 3U]) {}

  [[nodiscard]] float low(std::size_t axis) const {
    const auto i = static_cast<Eigen::Index>(axis);
    // Boxes of a BVH are about the middle of its mesh.
    if (parent == nullptr) return static_cast<float>(0.5 * (bvh.box().low[i] - bvh.box().high[i]));
    return parent->low[axis][static_cast<Eigen::Index>(child & 3U)];
  }
  [[nodiscard]] float high(std::size_t axis) const {
    if (parent == nullptr) return -low(axis);
    return parent->high[axis][static_cast<Eigen::Index>(child & 3U)];
  }
  [[nodiscard]] float size() const { return high(0) - low(0) + (high(1) - low(1)) + (high(2) - low(2)); }

  // Its own box, in place of its first child's.
  struct Alone {
    std::array<float, 12> low_m, high_m;
  };
  [[nodiscard]] FourBoxes boxes(bool split, Alone& alone) const {
    if (split) {
      const BvhNode& opened = bvh.nodes()[node];
      return {opened.low[0].data(), opened.high[0].data(), false};
    }
    for (std::size_t i = 0; i < 3; ++i) {
      alone.low_m[4 * i] = low(i);
      alone.high_m[4 * i] = high(i);
    }
    return {alone.low_m.data(), alone.high_m.data(), true};
  }
  [[nodiscard]] std::uint32_t node_at(bool split, std::uint32_t slot) const {
    return split ? bvh.nodes()[node].child[slot] : node;
  }
  [[nodiscard]] Child child_at(bool split, std::uint32_t slot) const { return split ? node << 2U | slot : child; }
  // A bit for each slot that holds something.
  [[nodiscard]] std::uint32_t filled(bool split) const {
    if (!split) return 1;
    std::uint32_t bits = 0;
    for (std::uint32_t k = 0; k < 4; ++k) bits |= (bvh.nodes()[node].child[k] != BvhNode::kNone ? 1U : 0U) << k;
    return bits;
  }
};

void SurfaceDescent::begin(const PlacedSurface& on_a, const PlacedSurface& on_b) {
  surface_a_ = on_a.surface;
  surface_b_ = on_b.surface;
  const TriangleBvh& bvh_a = surface_a_->bvh;
  const TriangleBvh& bvh_b = surface_b_->bvh;
  const Vec3 offset = on_b.point(bvh_b.origin_m()) - bvh_a.origin_m();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    frame_.offset_m[i] = static_cast<float>(offset[row]);
    for (std::size_t j = 0; j < 3; ++j) {
      frame_.rotation[i][j] = static_cast<float>(on_b.rotation(row, static_cast<Eigen::Index>(j)));
      frame_.absolute[i][j] = std::abs(frame_.rotation[i][j]);
    }
  }
  scale_m_ = offset.norm() + bvh_a.diagonal_m() + bvh_b.diagonal_m();
  stack_[0] = {kRoot, kRoot, 0};
  waiting_ = bvh_a.nodes().empty() || bvh_b.nodes().empty() ? 0 : 1;
  triangle_count_ = candidate_count_ = 0;
}

SurfaceDescent::Step SurfaceDescent::step(const SurfaceReach& reach) {
  const auto limit = static_cast<float>(reach.apart_m + kRounding * scale_m_);
  const float limit2 = limit * limit;
  while (waiting_ > 0 && !(stack_[waiting_ - 1].squared_m2 <= limit2)) --waiting_;
  if (triangle_count_ >= NearRows::kPairs || (waiting_ == 0 && triangle_count_ > 0)) {
    compare(reach);
    return Step::Triangles;
  }
  if (waiting_ == 0) return Step::Done;
  split(stack_[--waiting_], limit2);
  return Step::Split;
}

void SurfaceDescent::split(const Waiting& top, float limit_m2) {
  const Side a(*surface_a_, top.a);
  const Side b(*surface_b_, top.b);
  bool split_a = !is_triangle(a.node);
  bool split_b = !is_triangle(b.node);
  if (split_a && split_b) {
    const float size_a = a.size();
    const float size_b = b.size();
    split_a = !(size_b > kMuchLarger * size_a);
    split_b = !(size_a > kMuchLarger * size_b);
  }
  Side::Alone alone_a;
  Side::Alone alone_b;
  std::array<float, kBoxPairs> squared;
  std::uint32_t within = boxes_within(frame_, a.boxes(split_a, alone_a), b.boxes(split_b, alone_b), limit_m2, squared);
  const std::uint32_t filled_a = a.filled(split_a);
  const std::uint32_t filled_b = b.filled(split_b);
  std::uint32_t there = 0;
  for (std::uint32_t k = 0; k < 4; ++k) there |= (filled_a >> k & 1U) * filled_b << 4 * k;
  within &= there;
  // The nearest pair is on top of the stack.
  const std::size_t first = waiting_;
  for (; within != 0; within &= within - 1) {
    const auto pair = static_cast<std::uint32_t>(std::countr_zero(within));
    const std::uint32_t node_a = a.node_at(split_a, pair / 4);
    const std::uint32_t node_b = b.node_at(split_b, pair % 4);
    if (is_triangle(node_a) && is_triangle(node_b)) {
      triangles_[triangle_count_++] = {node_a & ~BvhNode::kTriangle, node_b & ~BvhNode::kTriangle, squared[pair]};
      continue;
    }
    std::size_t at = waiting_++;
    for (; at > first && stack_[at - 1].squared_m2 < squared[pair]; --at) stack_[at] = stack_[at - 1];
    stack_[at] = {a.child_at(split_a, pair / 4), b.child_at(split_b, pair % 4), squared[pair]};
  }
}

TriangleTest SurfaceDescent::test(const SurfaceReach& reach) const {
  return {static_cast<float>(reach.apart_m), static_cast<float>(reach.beneath_m),
          static_cast<float>(kTriangleRounding * scale_m_), surface_a_->solid, surface_b_->solid};
}

void SurfaceDescent::compare(const SurfaceReach& reach) {
  const std::size_t count = std::min(triangle_count_, NearRows::kPairs);
  const Waiting* const pairs = &triangles_[triangle_count_ - count];
  NearRows of_a;
  NearRows of_b;
  for (std::size_t k = 0; k < NearRows::kPairs; ++k) {
    of_a.set(k, surface_a_->near_triangles[pairs[std::min(k, count - 1)].a]);
    of_b.set(k, surface_b_->near_triangles[pairs[std::min(k, count - 1)].b]);
  }
  const TriangleAnswers answers = compare_triangles(frame_, test(reach), of_a, of_b);
  const bool features = std::max(reach.apart_m, reach.beneath_m) > 0;
  const auto touching = static_cast<float>(kRounding * scale_m_);
  candidate_count_ = 0;
  const std::uint32_t there = (1U << count) - 1;
  near_ = features ? static_cast<std::uint32_t>(std::popcount(answers.near & there)) : 0;
  const std::uint32_t may_face = features ? answers.may_face : 0;
  for (std::uint32_t left = (answers.may_cross | may_face) & there; left != 0; left &= left - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(left));
    // Triangles whose boxes are apart do not cross.
    const bool crosses = (answers.may_cross >> k & 1U) != 0 && pairs[k].squared_m2 <= touching * touching;
    const bool faces = (may_face >> k & 1U) != 0;
    if (!crosses && !faces) continue;
    candidates_[candidate_count_++] = {surface_a_->bvh.triangle_at(pairs[k].a), surface_b_->bvh.triangle_at(pairs[k].b),
                                       crosses, faces};
  }
  triangle_count_ -= count;
}

}  // namespace poise::collision
