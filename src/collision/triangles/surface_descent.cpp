// SPDX-License-Identifier: MIT
#include "collision/triangles/surface_descent.h"

#include <cmath>

namespace poise::collision {
namespace {

using geometry::BvhNode;
using Four = BvhNode::Four;

// Boxes are placed with some twenty roundings of coordinates no larger than both meshes and their distance.
constexpr double kRounding = 4e-6;

bool is_triangle(std::uint32_t child) { return (child & BvhNode::kTriangle) != 0; }

}  // namespace

void SurfaceDescent::begin(const PlacedSurface& on_a, const PlacedSurface& on_b) {
  bvh_a_ = &on_a.surface->bvh;
  bvh_b_ = &on_b.surface->bvh;
  const Vec3 offset = on_b.point(bvh_b_->origin_m()) - bvh_a_->origin_m();
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    offset_m_[i] = static_cast<float>(offset[row]);
    for (std::size_t j = 0; j < 3; ++j) {
      rotation_[i][j] = static_cast<float>(on_b.rotation(row, static_cast<Eigen::Index>(j)));
      absolute_[i][j] = std::abs(rotation_[i][j]);
    }
  }
  rounding_m_ = kRounding * (offset.norm() + bvh_a_->diagonal_m() + bvh_b_->diagonal_m());
  Waiting& roots = stack_[0];
  roots = {0, 0, 0, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    // Boxes of a BVH are about the middle of its mesh.
    roots.box_a.half_m[i] = static_cast<float>(0.5 * (bvh_a_->box().high[axis] - bvh_a_->box().low[axis]));
    roots.box_b.half_m[i] = static_cast<float>(0.5 * (bvh_b_->box().high[axis] - bvh_b_->box().low[axis]));
  }
  waiting_ = bvh_a_->nodes().empty() || bvh_b_->nodes().empty() ? 0 : 1;
}

SurfaceDescent::Step SurfaceDescent::step(double reach_m) {
  const auto reach = static_cast<float>(reach_m + rounding_m_);
  const float limit2 = reach * reach;
  while (waiting_ > 0) {
    const Waiting top = stack_[--waiting_];
    if (!(top.squared_m2 <= limit2)) continue;
    if (is_triangle(top.a) && is_triangle(top.b)) {
      triangle_a_ = bvh_a_->triangle_at(top.a & ~BvhNode::kTriangle);
      triangle_b_ = bvh_b_->triangle_at(top.b & ~BvhNode::kTriangle);
      const auto rounding = static_cast<float>(rounding_m_);
      may_cross_ = top.squared_m2 <= rounding * rounding;
      return Step::Triangles;
    }
    const auto size = [](const Box& box) { return box.half_m[0] + box.half_m[1] + box.half_m[2]; };
    if (is_triangle(top.b) || (!is_triangle(top.a) && size(top.box_a) >= size(top.box_b))) {
      split<true>(top, limit2);
    } else {
      split<false>(top, limit2);
    }
    return Step::Split;
  }
  return Step::Done;
}

template <bool kSplitA>
void SurfaceDescent::split(const Waiting& top, float limit2) {
  const BvhNode& node = kSplitA ? bvh_a_->nodes()[top.a] : bvh_b_->nodes()[top.b];
  std::array<Four, 3> center;
  std::array<Four, 3> half;
  for (std::size_t i = 0; i < 3; ++i) {
    center[i] = 0.5F * (node.low[i] + node.high[i]);
    half[i] = 0.5F * (node.high[i] - node.low[i]);
  }
  std::array<Four, 3> center_a;
  std::array<Four, 3> half_a;
  std::array<Four, 3> center_b;
  std::array<Four, 3> half_b;
  for (std::size_t i = 0; i < 3; ++i) {
    center_a[i] = kSplitA ? center[i] : Four::Constant(top.box_a.center_m[i]);
    half_a[i] = kSplitA ? half[i] : Four::Constant(top.box_a.half_m[i]);
    center_b[i] = kSplitA ? Four::Constant(top.box_b.center_m[i]) : center[i];
    half_b[i] = kSplitA ? Four::Constant(top.box_b.half_m[i]) : half[i];
  }
  // The distance of two boxes along a frame's axes: of one box and of the box around the other in that frame.
  std::array<Four, 3> between;
  Four along_a = Four::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const Four placed =
        rotation_[i][0] * center_b[0] + rotation_[i][1] * center_b[1] + rotation_[i][2] * center_b[2] + offset_m_[i];
    between[i] = center_a[i] - placed;
    const Four extent = absolute_[i][0] * half_b[0] + absolute_[i][1] * half_b[1] + absolute_[i][2] * half_b[2];
    const Four apart = (between[i].abs() - half_a[i] - extent).max(0.0F);
    along_a += apart * apart;
  }
  Four along_b = Four::Zero();
  for (std::size_t j = 0; j < 3; ++j) {
    const Four across = rotation_[0][j] * between[0] + rotation_[1][j] * between[1] + rotation_[2][j] * between[2];
    const Four extent = absolute_[0][j] * half_a[0] + absolute_[1][j] * half_a[1] + absolute_[2][j] * half_a[2];
    const Four apart = (across.abs() - half_b[j] - extent).max(0.0F);
    along_b += apart * apart;
  }
  const Four squared = along_a.max(along_b);
  // The nearest child is on top of the stack.
  const std::size_t first = waiting_;
  for (std::size_t slot = 0; slot < 4; ++slot) {
    const auto lane = static_cast<Eigen::Index>(slot);
    if (node.child[slot] == BvhNode::kNone || !(squared[lane] <= limit2)) continue;
    std::size_t at = waiting_++;
    for (; at > first && stack_[at - 1].squared_m2 < squared[lane]; --at) stack_[at] = stack_[at - 1];
    Waiting& next = stack_[at];
    next = top;
    next.squared_m2 = squared[lane];
    (kSplitA ? next.a : next.b) = node.child[slot];
    Box& box = kSplitA ? next.box_a : next.box_b;
    for (std::size_t i = 0; i < 3; ++i) {
      box.center_m[i] = center[i][lane];
      box.half_m[i] = half[i][lane];
    }
  }
}

}  // namespace poise::collision
