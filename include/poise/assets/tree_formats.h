// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "poise/mesh.h"
#include "poise/result.h"
#include "poise/sphere_tree.h"
#include "poise/types.h"

namespace poise {

/// Files that hold a tree or one of its levels (docs/sphere-trees.md).
enum class TreeFormat : std::uint8_t {
  Sph,         ///< the whole tree, as read_sph and write_sph define it
  Urdf,        ///< a URDF robot with one link that has a collision sphere for each ball
  CuroboYaml,  ///< cuRobo's `collision_spheres` of one link
  FoamJson,    ///< foam's list of levels, each with its spheres and errors
};

/// The format by the ending of a file name, in upper or lower case: .sph, .urdf, .yml or .yaml, .json; none for others.
/// Any thread.
std::optional<TreeFormat> tree_format_of(const std::filesystem::path& file);

/// Writes the spheres of `level` as collision spheres of a link `name`. A leaf above the level represents itself; below
/// the deepest level the leaves are written. Sph writes the whole tree and ignores level and name. FoamJson writes the
/// levels 0 to `level` and ignores the name; its errors are the smallest, mean and largest protrusion_max_m of the
/// level's spheres, in metres. Numbers are written with all digits, so that spheres that cover the object in memory
/// cover it in the file. The file appears complete or not at all. Any thread. Refused: a tree without nodes; a name
/// that is empty, longer than 256 bytes, not UTF-8 or with control characters.
Status write_tree(const SphereTree& tree, Level level, TreeFormat format, const std::string& name,
                  const std::filesystem::path& file);

/// Selects spheres of a file.
struct SphereChoice {
  std::string link = {};            ///< URDF and cuRobo: the link; may be empty if only one link has spheres
  std::optional<Level> level = {};  ///< Sph and foam: the level; the deepest one by default
};

/// Reads a set of spheres in the frame of its link, in metres, by the format of the file's ending. tree_of_spheres
/// makes a tree whose deepest level is this set. URDF links with other collision shapes than spheres are refused, since
/// the spheres would be only a part of the link. Refused with file and position: content that is not of the format, no
/// spheres or more than kMaxUnionSpheres, a centre that is not within 1e9 m, a radius not in [1e-9, 1e9] m, files above
/// 64 MiB, an unknown link or level. Any thread.
Result<std::vector<Sphere>> read_spheres(const std::filesystem::path& file, const SphereChoice& choice = {});

/// Quality of a tree that another program built, for a mesh.
struct ForeignTreeReport {
  std::vector<TreeLevelFigures> levels;
  double surface_coverage = 1;  ///< smallest over the levels, 0..1
  double inside_coverage = 1;   ///< smallest over the levels, 0..1
  /// Whether every sampled surface point is covered at every level, so that no contact is missed.
  [[nodiscard]] bool covers_surface() const { return surface_coverage >= 1; }
  /// One line of text: the coverage, and the level with uncovered points if there is one.
  [[nodiscard]] std::string summary() const;
};

/// Prepares a tree that another program built: measures it against its mesh (same frame) and computes the protrusions
/// and fitted spheres of its nodes, which files do not hold. The spheres of the tree do not change, whether or not they
/// cover the mesh; the caller decides by the report. Deterministic for a seed on any number of threads. Any thread.
/// Refused as measure_tree_quality refuses, including ErrorKind::Cancelled; the tree is then unchanged.
Result<ForeignTreeReport> adopt_tree(SphereTree& tree, const TriangleMesh& mesh,
                                     const TreeQualityOptions& options = {});

}  // namespace poise
