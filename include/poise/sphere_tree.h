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

inline constexpr std::uint32_t kTreeBranching = 8;

/// Version of the tree's layout and of what its figures mean; files and caches of another version are not used.
inline constexpr std::uint32_t kTreeVersion = 3;

/// Spheres that a union may have at most (five full levels).
inline constexpr std::size_t kMaxUnionSpheres = 32768;

/// A sphere with double precision, in metres, in the frame of its shape.
struct Sphere {
  Vec3 center_m = Vec3::Zero();
  double radius_m = 0;
};

/// The sphere that stands for a node in a contact (docs/method.md): fitted to the surface inside the node as seen from
/// outside. 24 bytes. Lengths in metres, in the frame of the tree.
struct NodeFit {
  float x_m = 0, y_m = 0, z_m = 0;  ///< centre
  float radius_m = 0;     ///< far below zero for a node without surface: used only where no other node has one
  float variance_m2 = 0;  ///< mean square of what the surface deviates from the sphere; 0 where it is the surface
  float core_m = 0;  ///< the ball of this radius about the centre is inside the object; negative: so far outside it is
};

/// A tree of covering spheres in flat arrays, level after level, children of a node contiguous.
///
/// Invariant (coverage): every point of the object has a chain of nodes from the root to a leaf that all
/// contain it. Children need not lie inside their parent. *Level L of the tree* is all nodes at level L
/// together with the leaves above it: a leaf stands for itself below.
///
/// The arrays are padded by kTreeBranching entries, so that eight floats can be loaded at any node.
struct SphereTree {
  std::vector<float> x_m, y_m, z_m, radius_m;
  std::vector<float>
      protrusion_max_m;  ///< by how much the exposed part of a node's sphere stands out of the object, at most
  std::vector<float>
      protrusion_mean_m;  ///< the same for the area-weighted mean; docs/sphere-trees.md says how near both bounds are
  std::vector<NodeFit> fit;               ///< fitted sphere of each node; its own sphere where nothing was fitted
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

/// How much time a tree is worth.
enum class TreePreset : std::uint8_t {
  Fast,  ///< about a third of the time of Default
  Default,
  Best,  ///< about seven times the time of Default
};

struct TreeBuildOptions {
  Level depth = 3;  ///< levels below the root, at most kMaxTreeDepth
  TreePreset preset = TreePreset::Default;
  Solidity solidity = Solidity::Solid;
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0 = as many as the machine has; the tree does not depend on it
  /// Called now and then on the calling thread with the share that is done, ascending from 0 to 1; may be empty.
  std::function<void(double share)> progress = {};
  std::stop_token stop = {};  ///< asks the build to end; it returns ErrorKind::Cancelled soon after
};

/// Builds a covering sphere tree of a mesh, in the frame of the mesh. Deterministic for a mesh and options on any
/// number of threads. Coverage of surface and inside is by construction, not by sampling (docs/sphere-trees.md). Any
/// thread. Refused: a mesh without triangles, or with indices, coordinates or a size out of range; a depth out of
/// range.
Result<SphereTree> build_sphere_tree(const TriangleMesh& mesh, const TreeBuildOptions& options);

/// The tree of an object that *is* a union of spheres: the leaves are its true surface (protrusion 0). Levels above
/// the leaves are grouped so that each node has at most eight children and its sphere holds all leaves below it, with
/// the fewest levels that n spheres can have. One sphere is a single node. Centres and radii are rounded to the nearest
/// float. Refused: no sphere, more than kMaxUnionSpheres, a centre that is not within 1e9 m, a radius not from 1e-9 to
/// 1e9 m.
Result<SphereTree> tree_of_spheres(std::span<const Sphere> spheres);

/// What a tree looks like at one level, measured by sampling against its mesh.
struct TreeLevelFigures {
  Level level = 0;
  std::size_t spheres = 0;
  double protrusion_max_m = 0;   ///< largest distance from exposed surface of the level to the mesh, where outside it
  double protrusion_mean_m = 0;  ///< area-weighted mean of the same
  double protrusion_bound_max_m =
      0;  ///< largest protrusion_max_m that the level's nodes store; not below protrusion_max_m if they are right
  double surface_coverage = 0;  ///< share of sampled surface points with a chain of nodes down to this level, 0..1
  double inside_coverage = 0;   ///< share of sampled inside points, likewise; 1 for an object without inside
  double volume_ratio = 0;  ///< volume of the union / volume of the object; 0 for an object without volume, as a shell
};

struct TreeQualityOptions {
  std::size_t samples = 20000;  ///< points a figure, from 1 to 1e8
  std::uint64_t seed = 1;
  Solidity solidity = Solidity::Solid;  ///< what counts as the object
  int threads = 0;                      ///< 0 = as many as the machine has; the figures do not depend on it
  std::stop_token stop = {};            ///< asks the measurement to end; it returns ErrorKind::Cancelled soon after
};

/// Measures a tree against the mesh it was built for (same frame). The volume of a closed mesh is exact, that of an
/// open one is sampled by winding number. Deterministic for a seed on any number of threads. Any thread. Refused: no
/// node, no triangle, an index or a coordinate out of range, options out of range.
Result<std::vector<TreeLevelFigures>> measure_tree_quality(const SphereTree& tree, const TriangleMesh& mesh,
                                                           const TreeQualityOptions& options);

}  // namespace poise
