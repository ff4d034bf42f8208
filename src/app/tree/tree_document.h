// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "poise/mesh.h"
#include "poise/sphere_tree.h"
#include "scene/made_by.h"

namespace poise::io {

/// What building a tree took.
struct TreeBuildCost {
  double wall_ms = 0;
  double cpu_ms = 0;             ///< of all threads
  std::uint64_t peak_bytes = 0;  ///< largest resident memory of the process meanwhile, the mesh included; 0 = unknown
};

/// A tree and what was found when it was measured against its mesh.
struct MeasuredTree {
  std::string file;                         ///< empty for a tree that was built here
  Level depth = 0;                          ///< that was asked for; of a tree from a file, its own
  TreePreset preset = TreePreset::Default;  ///< of a tree that was built here
  std::optional<TreeBuildCost> cost;        ///< of a tree that was built here
  std::size_t nodes = 0;
  std::size_t bytes = 0;  ///< of all its arrays, padding included
  std::vector<TreeLevelFigures> levels;
};

/// Everything that `poise tree` says of a mesh and one or two trees.
struct TreeDocument {
  std::string mesh;  ///< the file
  std::size_t vertices = 0, triangles = 0;
  MeshRepair repair;
  double diagonal_m = 0;
  std::string report;  ///< what the mesh is, in words
  bool closed = false;
  double volume_m3 = 0;
  Solidity solidity = Solidity::Solid;
  int threads = 0;
  std::size_t samples = 0;
  std::uint64_t seed = 0;
  std::vector<MeasuredTree> trees;  ///< one, or two that are compared
  Machine machine;
  BuildFacts build;
};

/// Bytes that the arrays of a tree hold.
std::size_t bytes_of(const SphereTree& tree);

/// Whether some sampled point of the object has no chain of nodes down to this level. Of a shell only the surface
/// counts.
bool leaks(const TreeLevelFigures& figures, Solidity solidity);
bool leaks(const MeasuredTree& tree, Solidity solidity);

std::string preset_name(TreePreset preset);

/// The document as `poise.tree/2` JSON, ending in a newline: the first tree's figures beside the mesh's, and where two
/// are compared each of them in `trees`.
std::string tree_json(const TreeDocument& document);

/// A link of a robot and the tree of its shapes.
struct RobotLink {
  std::string name;
  std::string shapes;                ///< which were taken, or why none: `collision`, `visual`, `none`, `spheres`
  std::optional<TreeDocument> tree;  ///< of `collision` and `visual`
};

/// The robot as `poise.robot-trees/1` JSON: for each link its shapes and, where it has a tree, what tree_json says.
std::string robot_json(const std::string& file, std::span<const RobotLink> links);

}  // namespace poise::io
