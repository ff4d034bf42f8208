// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "poise/mesh.h"
#include "poise/result.h"

namespace poise::geometry {

/// A node that places a mesh.
struct GltfNode {
  std::string name;                                         ///< of the node, else of its mesh, else `node N`
  std::size_t mesh = 0;                                     ///< index into GltfNodes::meshes
  Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();  ///< from the mesh to the scene
};

/// What the nodes of a glTF scene place, each mesh once and in its own frame, not welded.
struct GltfNodes {
  std::vector<GltfNode> nodes;  ///< without those whose mesh has no triangle
  std::vector<TriangleMesh> meshes;
};

/// As parse_gltf, but for putting all into one mesh. Refused as that.
Result<GltfNodes> parse_gltf_nodes(std::string_view bytes, const std::filesystem::path& folder);

}  // namespace poise::geometry
