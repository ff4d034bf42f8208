// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "assets/mesh/gltf_nodes.h"
#include "poise/result.h"
#include "scene/import/scene_draft.h"

namespace poise::io {

struct GltfImportSettings {
  std::vector<std::string> fixed;  ///< names of nodes that do not move
  bool all_fixed = false;
  bool floor = false;  ///< a half-space whose surface is at the lowest point
  double friction = 0.5;
  double scale = 1;  ///< metres per unit of the file, > 0; glTF has metres, but not everyone who writes it
};

/// The bodies of what parse_gltf_nodes has read. Refused as import_gltf, without the file.
Result<SceneDraft> gltf_draft(geometry::GltfNodes nodes, const GltfImportSettings& settings);

/// Reads a glTF or GLB file as bodies: each node that places a mesh with triangles becomes one. glTF has y upward; the
/// scene is turned so that z is. Any thread. Refused with the file: what read_mesh refuses, a name in `fixed` that no
/// such node has, nodes whose mesh has no extent.
Result<SceneDraft> import_gltf(const std::filesystem::path& file, const GltfImportSettings& settings);

}  // namespace poise::io
