// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "poise/result.h"
#include "poise/types.h"

namespace poise {

/// Triangles over shared vertices, in metres, counter-clockwise when seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  /// Length of the diagonal of the axis-aligned bounding box; 0 without vertices.
  [[nodiscard]] double diagonal_m() const;
};

/// What counts as the object that a mesh stands for.
enum class Solidity : std::uint8_t {
  Solid,  ///< the surface, and the points around which it winds (winding number above one half)
  Shell,  ///< the surface alone
};

/// What mesh reading did to the input, for a person to judge.
struct MeshRepair {
  std::size_t vertices_welded = 0;     ///< vertices that were merged into another
  std::size_t triangles_dropped = 0;   ///< triangles that name a vertex twice after welding, or repeat another
  bool flipped = false;                ///< the whole mesh was turned inside out to get a positive volume
};

struct MeshReadOptions {
  double scale = 1.0;                  ///< metres per unit of the file, > 0
  double weld_relative = 1e-6;         ///< vertices closer than this fraction of the diagonal are one, in [0, 0.1]
};

/// Mass properties at density 1 kg/m^3, so volumes are masses.
struct MassProperties {
  double volume_m3 = 0;
  Vec3 center_of_mass_m = Vec3::Zero();      ///< in the frame of the mesh
  Mat3 inertia_m5 = Mat3::Zero();            ///< about the centre of mass, axes of the mesh frame, symmetric
};

/// Reads an OBJ, STL, PLY, OFF, glTF or GLB file (chosen by its extension), welds and cleans it. Polygons are cut into
/// triangles; the transforms of glTF nodes are applied and all meshes of a file merged. Any thread.
/// Refused with file, and place where known: unreadable or unknown files, indices out of range, coordinates that are not
/// finite or (scaled) beyond 1e9 m, a diagonal under 1e-9 m, and files without a triangle. An open mesh is *not* refused
/// here; see check_closed.
Result<TriangleMesh> read_mesh(const std::filesystem::path& file, const MeshReadOptions& options,
                               MeshRepair* repair = nullptr);

/// Merges vertices within `weld_relative` (as in MeshReadOptions) of the diagonal into the lowest-numbered one, drops triangles
/// that name a vertex twice or repeat another, leaves out unused vertices, and turns a closed mesh of negative volume
/// inside out; in place. Needles with three distinct corners stay: without them a closed mesh would not be.
MeshRepair clean_mesh(TriangleMesh& mesh, double weld_relative);

/// How far a mesh is from enclosing a volume.
struct ClosedCheck {
  std::size_t open_edges = 0;           ///< edges with one triangle
  std::size_t inconsistent_edges = 0;   ///< edges whose triangles do not run through it in opposite directions in equal number
  [[nodiscard]] bool closed() const { return open_edges == 0 && inconsistent_edges == 0; }
};
ClosedCheck check_closed(const TriangleMesh& mesh);

/// Volume, centre of mass and inertia of a closed mesh in closed form (Eberly, "Polyhedral Mass
/// Properties", 2002, after Mirtich 1996). Refused: a mesh that is not closed, with the number of open
/// edges, and one whose volume is not positive.
Result<MassProperties> mesh_mass_properties(const TriangleMesh& mesh);

}  // namespace poise
