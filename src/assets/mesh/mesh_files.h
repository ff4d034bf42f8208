// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string_view>

#include "poise/mesh.h"

namespace poise::geometry {

// One function for each file format. They return the triangles of the file, unscaled and not welded, with every index
// checked and every coordinate finite, and use memory in proportion to the file. An Error's message is line or byte,
// value and rule, without the file's name. Any thread.

/// OBJ: vertices `v` and faces `f`; everything else is left out.
Result<TriangleMesh> parse_obj(std::string_view text);
/// OFF in its text form.
Result<TriangleMesh> parse_off(std::string_view text);
/// STL in its text and its binary form.
Result<TriangleMesh> parse_stl(std::string_view bytes);
/// PLY in its text form and both binary ones: faces and triangle strips.
Result<TriangleMesh> parse_ply(std::string_view bytes);

/// glTF and GLB of version 1 and 2: the meshes that the nodes of the scene place, merged. `folder` is that of the
/// file's buffers. Materials, names, skins and the like are not looked at, so that errors in them do not matter.
/// Refused: compressed meshes and instances by extensions, which would be read wrongly.
Result<TriangleMesh> parse_gltf(std::string_view bytes, const std::filesystem::path& folder);

}  // namespace poise::geometry
