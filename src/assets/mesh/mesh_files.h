// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "poise/mesh.h"

namespace poise::geometry {

// One function for each family of file formats. They return the triangles of the file, unscaled and not welded, with
// every index checked. An Error's message is the rule alone, without the file's name. Any thread.

/// OBJ by tinyobjloader. `file_text` is the whole file.
Result<TriangleMesh> parse_obj(const std::string& file_text);

/// STL, PLY and OFF by assimp.
Result<TriangleMesh> import_with_assimp(const std::filesystem::path& file);

/// glTF by assimp, from text without references to other files; the transforms of the nodes are applied and the meshes
/// merged.
Result<TriangleMesh> import_gltf_with_assimp(const std::string& text);

/// Extracts the geometry of a glTF or GLB file (version 1 or 2) as glTF text: nodes, meshes with their positions and
/// indices, and buffers, all inside the text. Materials, names, skins and the like are removed, so that errors in them
/// do not matter. `bytes` is the whole file, `folder` the folder of its buffers. Refused: content that is neither JSON
/// nor a container, a buffer that is missing or too short, a file without a scene, and several scenes without a valid
/// choice.
Result<std::string> plain_gltf(const std::string& bytes, const std::filesystem::path& folder);

}  // namespace poise::geometry
