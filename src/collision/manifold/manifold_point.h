// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "poise/types.h"

namespace poise::collision {

/// Largest number of contact points of a manifold.
inline constexpr std::size_t kMaxManifoldPoints = 8;

/// A contact point of a manifold, in the frame of a.
struct ManifoldPoint {
  Vec3 normal = Vec3::UnitZ();      ///< unit, from a to b
  Vec3 point_m = Vec3::Zero();      ///< in the middle between the two surfaces
  double gap_m = 0;                 ///< of the surfaces along the normal, negative in overlap
  double certain_separation_m = 0;  ///< >= gap_m; below zero the objects overlap here certainly
};

/// The manifold of one pair: at most kMaxManifoldPoints contact points; none where nothing is nearer than the margin.
struct ManifoldPoints {
  std::array<ManifoldPoint, kMaxManifoldPoints> point;
  std::size_t count = 0;
  [[nodiscard]] std::span<const ManifoldPoint> all() const { return std::span(point).first(count); }
};

}  // namespace poise::collision
