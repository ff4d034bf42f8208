// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "poise/mesh.h"

namespace poise::geometry {

// One file format family each. Both return the triangles as the file has them, unscaled and not welded, with every
// index checked; an Error's message is the rule alone, without the file's name. Any thread.

/// OBJ by tinyobjloader. `file_text` is the whole file.
Result<TriangleMesh> parse_obj(const std::string& file_text);

/// STL, PLY and OFF by assimp.
Result<TriangleMesh> import_with_assimp(const std::filesystem::path& file);

/// glTF by assimp, from text without references to other files; the transforms of the nodes are applied and the meshes
/// merged.
Result<TriangleMesh> import_gltf_with_assimp(const std::string& text);

/// Of a glTF or GLB file (version 1 or 2) what makes its shape, as glTF text: nodes, meshes with their positions and
/// indices, and buffers, all within the text. Materials, names, skins and the like are left out, so that a mistake in
/// them costs nothing. `bytes` is the whole file, `folder` where its buffers are. Refused: what is not JSON or no
/// container, a buffer that is not there or too short, a file without a scene or with several and none of them chosen
/// rightly.
Result<std::string> plain_gltf(const std::string& bytes, const std::filesystem::path& folder);

}  // namespace poise::geometry
