// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/primitives/bounds.h"
#include "query/triangle_queries.h"

namespace poise::query {

/// Distances at which a ray enters boxes, each enlarged by a radius.
class BoxRay {
 public:
  BoxRay(const Vec3& origin_m, const Vec3& direction, double grown_m) : origin_m_(origin_m), grown_m_(grown_m) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      moves_[static_cast<std::size_t>(axis)] = direction[axis] != 0;
      inverse_[axis] = direction[axis] != 0 ? 1.0 / direction[axis] : 0.0;
    }
  }
  /// Distance along the ray, 0 if the origin is inside; kMiss if the ray misses the box. Never above the true distance.
  [[nodiscard]] double enters_m(const Vec3& low, const Vec3& high) const {
    double enters = 0;
    double leaves = kMiss;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double below = low[axis] - grown_m_ - origin_m_[axis];
      const double above = high[axis] + grown_m_ - origin_m_[axis];
      if (!moves_[static_cast<std::size_t>(axis)]) {
        if (below > 0 || above < 0) return kMiss;
        continue;
      }
      const double t0 = below * inverse_[axis];
      const double t1 = above * inverse_[axis];
      enters = std::max(enters, std::min(t0, t1));
      leaves = std::min(leaves, std::max(t0, t1));
    }
    constexpr double kRounding = 1e-14;
    return enters * (1 - kRounding) <= leaves * (1 + kRounding) ? enters * (1 - kRounding) : kMiss;
  }

 private:
  Vec3 origin_m_;
  double grown_m_;
  Vec3 inverse_;
  std::array<bool, 3> moves_{};
};

/// Visits the triangles of a mesh, nearer boxes first. `bound(low, high)` returns a lower bound for everything in the
/// box, or kMiss; nodes with a bound not below limit() are skipped. `visit(index)` tests a triangle (by its index in
/// leaf order) and returns whether the search may end. At most 63 levels of four children, which the stack holds
/// (geometry/bvh/triangle_bvh.cpp).
template <class Bound, class Limit, class Visit>
void walk(const geometry::TriangleBvh& bvh, Bound&& bound, Limit&& limit, Visit&& visit) {
  using geometry::BvhNode;
  struct Waiting {
    double least;
    std::uint32_t child;
  };
  if (bvh.nodes().empty()) return;
  std::array<Waiting, 256> waiting;
  std::size_t count = 0;
  std::uint32_t next = 0;
  for (;;) {
    if ((next & BvhNode::kTriangle) != 0) {
      if (visit(next & ~BvhNode::kTriangle)) return;
    } else {
      const BvhNode& node = bvh.nodes()[next];
      const std::size_t base = count;
      for (std::size_t slot = 0; slot < 4; ++slot) {
        if (node.child[slot] == BvhNode::kNone) continue;
        const auto at = static_cast<Eigen::Index>(slot);
        const Vec3 low(static_cast<double>(node.low[0][at]), static_cast<double>(node.low[1][at]),
                       static_cast<double>(node.low[2][at]));
        const Vec3 high(static_cast<double>(node.high[0][at]), static_cast<double>(node.high[1][at]),
                        static_cast<double>(node.high[2][at]));
        const double least = bound(Vec3(bvh.origin_m() + low), Vec3(bvh.origin_m() + high));
        if (!(least <= limit()) || least == kMiss) continue;
        std::size_t place = count++;
        for (; place > base && waiting[place - 1].least < least; --place) waiting[place] = waiting[place - 1];
        waiting[place] = {least, node.child[slot]};
      }
    }
    do {
      if (count == 0) return;
      --count;
    } while (waiting[count].least > limit());
    next = waiting[count].child;
  }
}

}  // namespace poise::query
