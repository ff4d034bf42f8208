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

/// Where a ray enters boxes, each grown by a radius.
class BoxRay {
 public:
  BoxRay(const Vec3& origin_m, const Vec3& direction, double grown_m) : origin_m_(origin_m), grown_m_(grown_m) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      moves_[static_cast<std::size_t>(axis)] = direction[axis] != 0;
      inverse_[axis] = direction[axis] != 0 ? 1.0 / direction[axis] : 0.0;
    }
  }
  /// Distance along the ray, 0 from inside; kMiss where it passes by. Never later than the true one.
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

/// Goes through the triangles of a mesh, nearer boxes first. `bound(low, high)` gives a number below which nothing in
/// the box can be, or kMiss; what is not below limit() is left out. `visit(place)` looks at a triangle and says whether
/// that is enough. At most 63 levels of four children, so the list of what waits has room
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
