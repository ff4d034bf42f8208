// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
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

/// Repairs that mesh reading made.
struct MeshRepair {
  std::size_t vertices_welded = 0;      ///< vertices that were merged into another
  std::size_t triangles_discarded = 0;  ///< triangles that name a vertex twice after welding, or repeat another
  std::size_t triangles_turned = 0;     ///< triangles that were turned over to agree with their neighbours
  std::size_t pieces_turned = 0;  ///< pieces that were inside out and were turned over whole, with what lies in them
  bool flipped = false;           ///< every piece was turned over
};

/// Mass properties at density 1 kg/m^3, so volumes are masses.
struct MassProperties {
  double volume_m3 = 0;
  Vec3 center_of_mass_m = Vec3::Zero();  ///< in the frame of the mesh
  Mat3 inertia_m5 = Mat3::Zero();        ///< about the centre of mass, axes of the mesh frame, symmetric
};

/// Merges vertices within `weld_relative` of the diagonal (in [0, 0.1]) into the lowest-numbered one, drops
/// triangles that name a vertex twice or repeat another, leaves out unused vertices, and turns triangles over so that
/// neighbours agree on the outside and no piece is inside out, a cavity staying one (src/geometry/mesh_orient.h); in
/// place. Needles with three distinct corners stay: without them a closed mesh would not be. A second call changes
/// nothing.
MeshRepair clean_mesh(TriangleMesh& mesh, double weld_relative);

/// How far a mesh is from enclosing a volume.
struct ClosedCheck {
  std::size_t open_edges = 0;  ///< edges with one triangle
  std::size_t inconsistent_edges =
      0;  ///< edges whose triangles do not run through it in opposite directions in equal number
  std::size_t crowded_edges = 0;  ///< edges with more than two triangles, consistent or not
  [[nodiscard]] bool closed() const { return open_edges == 0 && inconsistent_edges == 0; }
};
/// How closed a mesh is. A triangle must not name a vertex twice or one that does not exist, as after clean_mesh.
ClosedCheck check_closed(const TriangleMesh& mesh);

/// Volume, centre of mass and inertia of a closed mesh in closed form (Eberly, "Polyhedral Mass
/// Properties", 2002, after Mirtich 1996). Refused: a mesh that is not closed, with the number of open
/// edges, and one whose volume is not positive.
Result<MassProperties> mesh_mass_properties(const TriangleMesh& mesh);

/// The same by sampling, with an estimate of the error.
struct SampledMass {
  MassProperties mass;
  double volume_error_m3 = 0;  ///< two standard deviations at most
  double firm_share = 0;       ///< share of the points inside around which the mesh winds more than 0.75 times
};

/// Mass of the points around which a mesh winds (winding number above one half, either way), whatever the mesh: some
/// 140,000 points of its box, one at random in each cell of a grid, the same ones at every call and for any number of
/// threads (0 = as many as the machine has). A mesh that encloses nothing has the volume 0 and no inertia. Any thread.
/// Refused: a mesh without triangles, or with indices or coordinates out of range.
Result<SampledMass> winding_mass_properties(const TriangleMesh& mesh, int threads = 0);

/// Mass of the surface itself as plates of this thickness, from 1e-9 to 1e9 m: area times thickness, centre and inertia
/// in closed form, as if plates could overlap at bends; a sheet that a file gives with both its faces counts twice. Any
/// thread. Refused: as winding_mass_properties, a thickness out of range, and a mesh without area.
Result<MassProperties> shell_mass_properties(const TriangleMesh& mesh, double thickness_m);

/// Properties of a mesh and what follows from them, in figures and in words.
struct MeshReport {
  std::size_t triangles = 0, vertices = 0;
  std::size_t pieces = 0;  ///< parts that share no edge
  std::size_t holes = 0;   ///< rims: connected rows of edges with one triangle
  ClosedCheck edges;
  double area_m2 = 0;
  double volume_m3 = 0;          ///< exact where the mesh is closed, else of the points around which it winds
  double volume_error_m3 = 0;    ///< of the sampling; 0 where the volume is exact
  double winding_volume_m3 = 0;  ///< by sampling, closed or not; smaller than volume_m3 where pieces overlap
  Solidity solidity =
      Solidity::Solid;      ///< Shell where it encloses nothing worth the name: then a thickness must be given
  bool exact_mass = false;  ///< closed, and its mass comes from exact integrals
  std::string text;         ///< one or two sentences for a person, no line end
};

/// Assesses a mesh, as clean_mesh leaves it. Any thread. Refused: as winding_mass_properties.
Result<MeshReport> assess_mesh(const TriangleMesh& mesh, int threads = 0);

}  // namespace poise
