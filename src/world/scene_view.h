// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "dynamics/body_store.h"
#include "poise/shape.h"
#include "poise/world.h"
#include "query/inner_solids.h"

namespace poise::simulation {

/// What is known of a shape before any step.
struct ShapeFacts {
  ShapePtr shape;
  std::array<float, kMaxTreeDepth + 1>
      error_m{};  ///< area-weighted mean protrusion of each level; the last one repeats
  std::array<double, kMaxTreeDepth + 1>
      deviation_m{};          ///< of the surface from the fits of each level, the mean over its nodes; likewise
  double least_extent_m = 0;  ///< collision::least_extent_m
  std::vector<query::InnerSolid> inner_solids;  ///< found when a policy first asks for what hides what
  bool inner_solids_found = false;
};

/// The bodies of a World and what they are made of, for reading. Any thread, while nobody writes the bodies.
struct SceneView {
  const dynamics::BodyStore& bodies;
  std::span<const std::uint32_t> shape_of;  ///< one a slot: index into shapes
  std::span<const ShapeFacts> shapes;
  std::span<const Material> materials;

  [[nodiscard]] const ShapeFacts& facts_of(std::size_t slot) const { return shapes[shape_of[slot]]; }
  /// Of the contact of two bodies.
  [[nodiscard]] Material mixed_material(std::size_t slot_a, std::size_t slot_b) const {
    const Material& a = materials[bodies.material[slot_a]];
    const Material& b = materials[bodies.material[slot_b]];
    if (&a == &b) return a;
    Material both;
    both.restitution = std::max(a.restitution, b.restitution);
    both.friction = std::sqrt(a.friction * b.friction);
    return both;
  }
};

}  // namespace poise::simulation
