// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <span>

#include "poise/types.h"

namespace poise::geometry {

/// An axis-aligned box; empty (low above high) until something is added.
struct Bounds {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 high = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vec3& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  void add(const Bounds& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  [[nodiscard]] Vec3 center() const { return 0.5 * (low + high); }
  /// Squared distance from a point to the box, 0 inside.
  [[nodiscard]] double squared_distance(const Vec3& point) const {
    return (low - point).cwiseMax(point - high).cwiseMax(0.0).squaredNorm();
  }
};

inline Bounds bounds_of(std::span<const Vec3> points) {
  Bounds bounds;
  for (const Vec3& point : points) bounds.add(point);
  return bounds;
}

}  // namespace poise::geometry
