// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "poise/scene.h"

namespace poise::io {

/// Loads or makes the shapes of a scene, in its order; sphere trees are built on up to `threads` threads (0 = all).
/// Refused with scene file and field.
Result<std::vector<ShapePtr>> load_shapes(const Scene& scene, int threads);

/// The notes of shapes that load_shapes made, with scene file and field.
std::vector<std::string> shape_warnings(const Scene& scene, std::span<const ShapePtr> shapes);

/// A tree `scale` times as large. Inner spheres are rounded outward, so that they still cover; leaves are the surface.
SphereTree scaled_tree(SphereTree tree, double scale);

}  // namespace poise::io
