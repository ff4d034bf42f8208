// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "poise/mesh.h"
#include "poise/result.h"

namespace poise {

/// Unit and tolerance of a mesh file.
struct MeshReadOptions {
  double scale = 1.0;           ///< metres per unit of the file, > 0
  double weld_relative = 1e-6;  ///< vertices closer than this fraction of the diagonal are merged, in [0, 0.1]
};

/// Reads an OBJ, STL, PLY, OFF, glTF or GLB file (chosen by its extension), then welds and cleans it (clean_mesh).
/// Polygons are cut into triangles. The transforms of glTF nodes are applied, and all meshes of a file are merged.
/// `repair`, if given, receives the repairs. Any thread.
/// Refused with the file and, if known, the position in it: unreadable or unknown files, indices out of range,
/// coordinates that are not finite or (scaled) beyond 1e9 m, a diagonal under 1e-9 m, and files without a triangle. An
/// open mesh is *not* refused; see check_closed.
Result<TriangleMesh> read_mesh(const std::filesystem::path& file, const MeshReadOptions& options,
                               MeshRepair* repair = nullptr);

}  // namespace poise
