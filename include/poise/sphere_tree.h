// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "poise/mesh.h"
#include "poise/result.h"
#include "poise/types.h"

namespace poise {

/// The most children of a node.
inline constexpr std::uint32_t kTreeBranching = 8;

/// Version of the tree's layout and of the definition of its figures; files and caches of another version are not used.
inline constexpr std::uint32_t kTreeVersion = 3;

/// The most spheres of a union (five full levels).
inline constexpr std::size_t kMaxUnionSpheres = 32768;

/// A sphere with double precision, in metres, in the frame of its shape.
struct Sphere {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;
};

/// The sphere that represents a node in a contact (docs/method.md): fitted to the surface inside the node that is
/// visible from outside. 24 bytes. Lengths in metres, in the frame of the tree.
struct NodeFit {
  float x_m = 0, y_m = 0, z_m = 0;  ///< centre
  float radius_m = 0;     ///< far below zero for a node without surface, which is used only if no other node has one
  float variance_m2 = 0;  ///< mean square deviation of the surface from the sphere; 0 where the sphere is the surface
  float core_m = 0;  ///< radius of a ball about the centre that is inside the object; negative: distance of the centre
                     ///< outside it
};

/// A tree of covering spheres in flat arrays, level after level; the children of a node are contiguous.
///
/// Invariant (coverage): for every point of the object there is a chain of nodes from the root to a leaf, each of which
/// contains the point. Children need not lie inside their parent. *Level L of the tree* is all nodes at level L
/// together with the leaves above it: a leaf represents itself at deeper levels.
///
/// The arrays are padded by kTreeBranching entries, so that eight floats can be loaded at any node.
struct SphereTree {
  std::vector<float> x_m, y_m, z_m, radius_m;
  /// Upper bound of the distance by which the exposed part of a node's sphere protrudes from the object.
  std::vector<float> protrusion_max_m;
  /// Upper bound of the area-weighted mean of the same distance; docs/sphere-trees.md says how tight both bounds are.
  std::vector<float> protrusion_mean_m;
  std::vector<NodeFit> fit;               ///< fitted sphere of each node; the node's own sphere if nothing was fitted
  std::vector<NodeIndex> first_child;     ///< index of the first child; the node itself for a leaf
  std::vector<std::uint8_t> child_count;  ///< 0 for a leaf, at most kTreeBranching
  std::vector<NodeIndex> level_begin;     ///< first node of each level, then the number of nodes

  [[nodiscard]] std::size_t node_count() const { return level_begin.empty() ? 0 : level_begin.back(); }
  /// Level of the deepest node; 0 for one sphere.
  [[nodiscard]] Level depth() const { return static_cast<Level>(level_begin.size() < 2 ? 0 : level_begin.size() - 2); }
  /// Nodes of level L as defined above, in order.
  [[nodiscard]] std::vector<NodeIndex> nodes_at(Level level) const;
  [[nodiscard]] Sphere sphere(NodeIndex node) const {
    return {Vec3(static_cast<double>(x_m[node]), static_cast<double>(y_m[node]), static_cast<double>(z_m[node])),
            static_cast<double>(radius_m[node])};
  }
};

/// Time spent on a tree against its quality.
enum class TreePreset : std::uint8_t {
  Fast,  ///< about a third of the time of Default
  Default,
  Best,  ///< about seven times the time of Default
};

/// Options of build_sphere_tree.
struct TreeBuildOptions {
  Level depth = 3;  ///< levels below the root, at most kMaxTreeDepth
  TreePreset preset = TreePreset::Default;
  Solidity solidity = Solidity::Solid;
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0 = as many as the machine has; the tree does not depend on it
  /// Called from time to time on the calling thread with the completed share, ascending from 0 to 1; may be empty.
  std::function<void(double share)> progress = {};
  std::stop_token stop = {};  ///< stops the build, which returns ErrorKind::Cancelled soon after
};

/// Builds a covering sphere tree of a mesh, in the frame of the mesh. Deterministic for a mesh and options on any
/// number of threads. Coverage of surface and inside is by construction, not by sampling (docs/sphere-trees.md). Any
/// thread. Refused: a mesh without triangles, or with indices, coordinates or a size out of range; a depth out of
/// range.
Result<SphereTree> build_sphere_tree(const TriangleMesh& mesh, const TreeBuildOptions& options);

/// Options of tree_of_spheres.
struct UnionTreeOptions {
  int threads = 0;            ///< 0 = as many as the machine has; the tree does not depend on it
  std::stop_token stop = {};  ///< stops the build, which returns ErrorKind::Cancelled soon after
};

/// The tree of an object that *is* a union of spheres: the leaves are its true surface (protrusion 0). The levels above
/// are grouped so that each node has at most eight children and its sphere contains all leaves below it, with the
/// fewest levels that n spheres can have. One sphere is a single node. Centres and radii are rounded to the nearest
/// float. Takes some milliseconds a sphere where there are thousands. Any thread. Refused: no sphere, more than
/// kMaxUnionSpheres, a centre that is not within 1e9 m, a radius not in [1e-9, 1e9] m.
Result<SphereTree> tree_of_spheres(std::span<const Sphere> spheres, const UnionTreeOptions& options = {});

/// Quality of a tree at one level, measured by sampling against its mesh.
struct TreeLevelFigures {
  Level level = 0;
  std::size_t spheres = 0;
  double protrusion_max_m = 0;   ///< largest distance from the exposed surface of the level to the mesh, outside the
                                 ///< object
  double protrusion_mean_m = 0;  ///< area-weighted mean of the same
  /// Largest protrusion_max_m stored in the level's nodes; not below protrusion_max_m if the stored bounds hold.
  double protrusion_bound_max_m = 0;
  double surface_coverage = 0;  ///< share of sampled surface points with a chain of nodes down to this level, 0..1
  double inside_coverage = 0;   ///< share of sampled inside points, likewise; 1 for an object without inside
  double volume_ratio = 0;      ///< volume of the union / volume of the object; 0 for an object without volume, e.g. a
                                ///< shell
};

/// Options of measure_tree_quality.
struct TreeQualityOptions {
  std::size_t samples = 20000;  ///< sampled points for each figure, in [1, 1e8]
  std::uint64_t seed = 1;
  Solidity solidity = Solidity::Solid;  ///< which points belong to the object
  int threads = 0;                      ///< 0 = as many as the machine has; the figures do not depend on it
  std::stop_token stop = {};            ///< stops the measurement, which returns ErrorKind::Cancelled soon after
};

/// Measures a tree against the mesh it was built for (same frame). The volume of a closed mesh is exact; that of an
/// open one is sampled by winding number. Deterministic for a seed on any number of threads. Any thread. Refused: a
/// tree without nodes, a mesh without triangles, indices or coordinates out of range, options out of range.
Result<std::vector<TreeLevelFigures>> measure_tree_quality(const SphereTree& tree, const TriangleMesh& mesh,
                                                           const TreeQualityOptions& options);

}  // namespace poise
