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
  Sph,         ///< the whole tree, as read_sph and write_sph have it
  Urdf,        ///< a URDF robot of one link with a collision sphere for each ball
  CuroboYaml,  ///< cuRobo's `collision_spheres` of one link
  FoamJson,    ///< foam's list of levels, each with its spheres and errors
};

/// By the ending of a file name, in either case: .sph, .urdf, .yml or .yaml, .json; none for others.
std::optional<TreeFormat> tree_format_of(const std::filesystem::path& file);

/// Writes the spheres of `level` (a leaf above stands for itself; below the deepest level, the leaves) as collision
/// spheres of a link `name`. Sph writes the whole tree and ignores level and name; FoamJson writes the levels 0 to
/// `level` and ignores the name; its errors are the smallest, mean and largest protrusion_max_m of the level's spheres,
/// in metres. Numbers are written exactly, so that what covers in the tree covers in the file. Appears whole or not at
/// all. Any thread. Refused: a tree without nodes; a name that is empty, longer than 256 bytes, not UTF-8 or with
/// control characters.
Status write_tree(const SphereTree& tree, Level level, TreeFormat format, const std::string& name,
                  const std::filesystem::path& file);

/// Which spheres of a file are meant.
struct SphereChoice {
  std::string link = {};            ///< URDF and cuRobo: the link; may be empty where only one has spheres
  std::optional<Level> level = {};  ///< Sph and foam: the level; the deepest one by default
};

/// Reads a set of spheres in the frame of its link, format by the ending of the file: for a tree by tree_of_spheres,
/// whose deepest level is the set. URDF links with other collision shapes than spheres are refused, since a part of a
/// link is not the link. Refused with file and place: what is not of the format, no or more than kMaxUnionSpheres
/// spheres, a centre that is not within 1e9 m, a radius not from 1e-9 to 1e9 m, files above 64 MiB, an unknown link or
/// level. Any thread.
Result<std::vector<Sphere>> read_spheres(const std::filesystem::path& file, const SphereChoice& choice = {});

/// Quality of a foreign tree for a mesh.
struct ForeignTreeReport {
  std::vector<TreeLevelFigures> levels;
  double surface_coverage = 1;  ///< smallest over the levels, 0..1
  double inside_coverage = 1;   ///< smallest over the levels, 0..1
  /// No sampled point of the surface is left out at any level, so that no contact is missed.
  [[nodiscard]] bool covers_surface() const { return surface_coverage >= 1; }
  /// One line for a person: what is covered, and at which level it leaks.
  [[nodiscard]] std::string summary() const;
};

/// Adopts a tree that was not built here: measures it against its mesh (same frame), and fills what its nodes know of
/// protrusion and surface, which files do not have. The tree's spheres stay as they are, leaking or not: the caller
/// decides by the report. Deterministic for a seed on any number of threads. Any thread. Refused as
/// measure_tree_quality refuses, ErrorKind::Cancelled among it; the tree is then as it was.
Result<ForeignTreeReport> adopt_tree(SphereTree& tree, const TriangleMesh& mesh,
                                     const TreeQualityOptions& options = {});

}  // namespace poise
