// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "poise/scene/scene.h"

namespace poise::io {

struct LoadSettings {
  int threads = 0;                                  ///< most threads for building sphere trees, 0 = all
  std::optional<TreeCacheSettings> tree_cache;      ///< empty: every tree is built
  std::function<void(double share)> progress = {};  ///< called on the calling thread, with the completed share of the
                                                    ///< shapes, 0 to 1
  std::stop_token stop = {};                        ///< ends the loading
};

struct LoadedShapes {
  std::vector<ShapePtr> shapes;  ///< in the order of the scene
  TreeCacheUse tree_cache_use;
};

/// Loads or makes the shapes of a scene. Refused with scene file and field, and as Cancelled when it is stopped.
Result<LoadedShapes> load_shapes(const Scene& scene, const LoadSettings& settings);

/// One shape as load_shapes makes it, except that a mesh's tree that is not in a cache is not built:
/// ErrorKind::Cancelled. The tree of a union of spheres is built.
Result<ShapePtr> load_without_building(const Scene& scene, const SceneShape& shape, const LoadSettings& settings);

/// The mesh of a shape, scaled and rotated as in the scene.
Result<TriangleMesh> scene_mesh(const Scene& scene, const MeshSource& source);

/// The files that a scene names: of its shapes and its gaze. None of them is opened.
std::vector<std::filesystem::path> files_of(const Scene& scene);

/// File and field of a shape, for messages: `pile.json: shapes.jack.mesh`.
std::string place_of(const Scene& scene, const SceneShape& shape);

/// The notes of the shapes from load_shapes, with scene file and field.
std::vector<std::string> shape_warnings(const Scene& scene, std::span<const ShapePtr> shapes);

/// A tree `scale` times as large. Spheres are rounded outward, so that they still cover the object. Leaves that are the
/// surface are not rounded outward.
SphereTree scaled_tree(SphereTree tree, double scale, bool leaves_are_surface);

}  // namespace poise::io
