// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "poise/scene/scene.h"

namespace poise::io {

struct LoadSettings {
  int threads = 0;                              ///< sphere trees are built on up to so many, 0 = all
  std::optional<TreeCacheSettings> tree_cache;  ///< none: every tree is built
};

struct LoadedShapes {
  std::vector<ShapePtr> shapes;  ///< in the order of the scene
  TreeCacheUse tree_cache_use;
};

/// Loads or makes the shapes of a scene. Refused with scene file and field.
Result<LoadedShapes> load_shapes(const Scene& scene, const LoadSettings& settings);

/// The notes of shapes that load_shapes made, with scene file and field.
std::vector<std::string> shape_warnings(const Scene& scene, std::span<const ShapePtr> shapes);

/// A tree `scale` times as large. Spheres are rounded outward, so that they still cover; leaves only where they are not
/// the surface.
SphereTree scaled_tree(SphereTree tree, double scale, bool leaves_are_surface);

}  // namespace poise::io
