// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "poise/mesh.h"
#include "poise/result.h"

namespace poise {

struct MeshReadOptions {
  double scale = 1.0;           ///< metres per unit of the file, > 0
  double weld_relative = 1e-6;  ///< vertices closer than this fraction of the diagonal are one, in [0, 0.1]
};

/// Reads an OBJ, STL, PLY, OFF, glTF or GLB file (chosen by its extension), welds and cleans it. Polygons are cut into
/// triangles; the transforms of glTF nodes are applied and all meshes of a file merged. Any thread.
/// Refused with file, and place where known: unreadable or unknown files, indices out of range, coordinates that are
/// not finite or (scaled) beyond 1e9 m, a diagonal under 1e-9 m, and files without a triangle. An open mesh is *not*
/// refused here; see check_closed.
Result<TriangleMesh> read_mesh(const std::filesystem::path& file, const MeshReadOptions& options,
                               MeshRepair* repair = nullptr);

}  // namespace poise
