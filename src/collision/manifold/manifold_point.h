// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "poise/types.h"

namespace poise::collision {

/// Places at which a pair may rest on each other at once.
inline constexpr std::size_t kMaxManifoldPoints = 4;

/// One of these places, in the frame of a: surfaces that face each other there and may only slide.
struct ManifoldPoint {
  Vec3 normal = Vec3::UnitZ();      ///< unit, from a to b
  Vec3 point_m = Vec3::Zero();      ///< in the middle between the two surfaces
  double gap_m = 0;                 ///< of the surfaces along the normal, negative in overlap
  double certain_separation_m = 0;  ///< >= gap_m; below zero the objects overlap here beyond doubt
};

/// The places of one pair, at most kMaxPatches; none where nothing is nearer than the margin.
struct ManifoldPoints {
  std::array<ManifoldPoint, kMaxManifoldPoints> manifold_point;
  std::size_t count = 0;
  [[nodiscard]] std::span<const ManifoldPoint> all() const { return std::span(manifold_point).first(count); }
};

}  // namespace poise::collision
