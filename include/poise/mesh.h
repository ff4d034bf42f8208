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

/// Which points belong to the object that a mesh describes.
enum class Solidity : std::uint8_t {
  Solid,  ///< the surface, and the points with a winding number above one half
  Shell,  ///< the surface alone
};

/// Repairs that mesh reading made.
struct MeshRepair {
  std::size_t vertices_welded = 0;      ///< vertices that were merged into another
  std::size_t triangles_discarded = 0;  ///< triangles that name a vertex twice after welding, or repeat another
  std::size_t triangles_turned = 0;     ///< triangles whose orientation was reversed to agree with their neighbours
  std::size_t pieces_turned = 0;  ///< pieces that were inside out and were reversed as a whole, with what they contain
  bool flipped = false;           ///< every piece was reversed
};

/// Mass properties at density 1 kg/m^3: a volume in m^3 equals the mass in kg.
struct MassProperties {
  double volume_m3 = 0;
  Vec3 center_of_mass_m = Vec3::Zero();  ///< in the frame of the mesh
  Mat3 inertia_m5 = Mat3::Zero();        ///< about the centre of mass, axes of the mesh frame, symmetric
};

/// Welds and cleans a mesh in place. Merges vertices within `weld_relative` of the diagonal (in [0, 0.1]) into the one
/// with the lowest number. Removes triangles that name a vertex twice or repeat another, and unused vertices. Reverses
/// triangles so that neighbours agree on the outside and no piece is inside out; a cavity stays a cavity
/// (src/geometry/mesh/mesh_orient.h). Needles with three distinct corners stay, since a closed mesh would be open
/// without them. A second call changes nothing.
MeshRepair clean_mesh(TriangleMesh& mesh, double weld_relative);

/// How far a mesh is from enclosing a volume.
struct ClosedCheck {
  std::size_t open_edges = 0;  ///< edges with one triangle
  /// edges whose triangles do not use it equally often in either direction
  std::size_t inconsistent_edges = 0;
  std::size_t crowded_edges = 0;  ///< edges with more than two triangles, consistent or not
  [[nodiscard]] bool closed() const { return open_edges == 0 && inconsistent_edges == 0; }
};
/// Counts the edges at which a mesh is not closed. Each triangle must name three different vertices that exist, as
/// after clean_mesh.
ClosedCheck check_closed(const TriangleMesh& mesh);

/// Volume, centre of mass and inertia of a closed mesh in closed form (Eberly, "Polyhedral Mass Properties", 2002,
/// after Mirtich 1996). Any thread. Refused: a mesh that is not closed (the message gives the number of open edges),
/// and one whose volume is not positive.
Result<MassProperties> mesh_mass_properties(const TriangleMesh& mesh);

/// Mass properties by sampling, with an estimate of the error.
struct SampledMass {
  MassProperties mass;
  double volume_error_m3 = 0;  ///< two standard deviations at most
  double certain_share = 0;    ///< share of the inside points whose winding number is above 0.75
};

/// Mass properties of the points with a winding number above one half in absolute value; the mesh may be open. Samples
/// about 140,000 points of the mesh's box, one at random in each cell of a grid. The points are the same at every call
/// and for any number of `threads` (0 = as many as the machine has). A mesh that encloses nothing has volume 0 and
/// inertia 0. Any thread. Refused: a mesh without triangles, or with indices or coordinates out of range.
Result<SampledMass> winding_mass_properties(const TriangleMesh& mesh, int threads = 0);

/// Mass properties of the surface as plates of `thickness_m`, in [1e-9, 1e9] m: area times thickness, centre and
/// inertia in closed form. Overlaps at bends are not subtracted. A sheet that the file gives with both its faces counts
/// twice. Any thread. Refused: as winding_mass_properties, a thickness out of range, and a mesh without area.
Result<MassProperties> shell_mass_properties(const TriangleMesh& mesh, double thickness_m);

/// Properties of a mesh, as figures and as text.
struct MeshReport {
  std::size_t triangles = 0, vertices = 0;
  std::size_t pieces = 0;  ///< parts that share no edge
  std::size_t holes = 0;   ///< rims: connected chains of edges with one triangle
  ClosedCheck edges;
  double area_m2 = 0;
  double volume_m3 = 0;          ///< exact where the mesh is closed, else of the points with a winding number above one
                                 ///< half
  double volume_error_m3 = 0;    ///< of the sampling; 0 where the volume is exact
  double winding_volume_m3 = 0;  ///< by sampling, closed or not; smaller than volume_m3 where pieces overlap
  /// Shell where the enclosed volume is too small to be a solid: a shape then needs a thickness.
  Solidity solidity = Solidity::Solid;
  bool exact_mass = false;  ///< closed, and its mass comes from exact integrals
  std::string text;         ///< one or two sentences for a person, no line end
};

/// Assesses a mesh that clean_mesh has cleaned. `threads`: 0 = as many as the machine has. Any thread. Refused: as
/// winding_mass_properties.
Result<MeshReport> assess_mesh(const TriangleMesh& mesh, int threads = 0);

}  // namespace poise
