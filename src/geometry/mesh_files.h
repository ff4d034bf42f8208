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

/// STL, PLY, OFF, glTF and GLB by assimp; the transforms of the nodes are applied and all meshes merged.
Result<TriangleMesh> import_with_assimp(const std::filesystem::path& file);

}  // namespace poise::geometry
