// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "geometry/mesh_volume.h"
#include "geometry/rounding.h"
#include "geometry/solid_atoms.h"
#include "geometry/tree_layout.h"
#include "geometry/tree_protrusion.h"
#include "geometry/tree_split.h"
#include "geometry/triangle_bvh.h"
#include "poise/sphere_tree.h"

namespace poise {
namespace {

using namespace geometry;

/// Atoms for each leaf that a full tree would have: more make tighter balls and take longer. Chosen, see docs/sphere-trees.md.
constexpr std::size_t kAtomsPerLeaf = 16;
constexpr std::size_t kFewestAtoms = 4096;
constexpr std::size_t kMostAtoms = 300000;
/// A ball that cannot stand out by more than this share of the diagonal is not split further (docs/sphere-trees.md).
constexpr double kGoodEnough = 0.001;

std::size_t atoms_for(Level depth) {
  std::size_t leaves = 1;
  for (Level l = 0; l < depth; ++l) leaves *= kTreeBranching;
  return std::clamp(kAtomsPerLeaf * leaves, kFewestAtoms, kMostAtoms);
}

struct OpenNode {
  std::uint32_t node;                  ///< index among the loose nodes
  std::vector<std::uint32_t> members;  ///< its atoms
  DeepBall ball;
};

LooseNode closed_node(const SolidAtoms& atoms, const OpenNode& open, double scale_m) {
  LooseNode node;
  node.center_m = to_float(open.ball.sphere.center_m);
  const Vec3 center = node.center_m.cast<double>();
  double squared_m2 = 0;
  for (const std::uint32_t atom : open.members) {
    for (const Vec3& p : atoms.points_of(atom)) squared_m2 = std::max(squared_m2, (p - center).squaredNorm());
  }
  node.radius_m = covering_radius(std::sqrt(squared_m2), scale_m);
  return node;
}

/// The groups of a node's children; none where the node ends early.
std::vector<SplitGroup> children_of(const SolidAtoms& atoms, const OpenNode& open, const TriangleBvh& bvh, double diagonal_m,
                                    std::uint64_t seed) {
  const DeepBall& own = open.ball;
  if (open.members.size() < 2 || own.protrusion_bound_m <= kGoodEnough * diagonal_m) return {};
  std::vector<SplitGroup> groups = split_atoms(atoms, open.members, bvh, seed);
  double largest_radius_m = 0;
  double largest_bound_m = 0;
  for (const SplitGroup& group : groups) {
    largest_radius_m = std::max(largest_radius_m, group.ball.sphere.radius_m);
    largest_bound_m = std::max(largest_bound_m, group.ball.protrusion_bound_m);
  }
  if (largest_radius_m >= 0.99 * own.sphere.radius_m && largest_bound_m >= own.protrusion_bound_m) return {};
  return groups;
}

/// The tree's nodes, level after level. The nodes of a level are split side by side, and each split depends on its node alone.
std::vector<LooseNode> grow(const SolidAtoms& atoms, const TriangleBvh& bvh, double diagonal_m, const TreeBuildOptions& options,
                            parallel::Executor& executor) {
  std::vector<LooseNode> nodes;
  std::vector<OpenNode> level(1);
  level[0].node = 0;
  level[0].members.resize(atoms.size());
  std::iota(level[0].members.begin(), level[0].members.end(), 0U);
  // The root is the smallest ball: bounds and the broad phase go by its size, not by how well it fits.
  level[0].ball = deep_ball(atoms, level[0].members, bvh, 1e6);
  nodes.push_back(closed_node(atoms, level[0], diagonal_m));
  for (Level depth = 0; depth < options.depth && !level.empty(); ++depth) {
    std::vector<std::vector<SplitGroup>> groups(level.size());
    parallel::parallel_for(executor, level.size(), 1, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint64_t seed = options.seed ^ (std::uint64_t{level[i].node} + 1) * 0x9e3779b97f4a7c15ULL;
        groups[i] = children_of(atoms, level[i], bvh, diagonal_m, seed);
      }
    });
    std::vector<OpenNode> next;
    for (std::size_t i = 0; i < level.size(); ++i) {
      for (SplitGroup& group : groups[i]) {
        const auto child = static_cast<std::uint32_t>(nodes.size());
        nodes[level[i].node].children.push_back(child);
        next.push_back({child, std::move(group.members), group.ball});
        nodes.push_back(closed_node(atoms, next.back(), diagonal_m));
      }
    }
    level = std::move(next);
  }
  return nodes;
}

}  // namespace

Result<SphereTree> build_sphere_tree(const TriangleMesh& mesh, const TreeBuildOptions& options) {
  if (options.depth > kMaxTreeDepth) return bad_input(fmt::format("depth = {}, must be from 0 to {}", options.depth, kMaxTreeDepth));
  if (options.threads < 0 || options.threads > 256) return bad_input(fmt::format("threads = {}, must be from 0 to 256", options.threads));
  if (std::string wrong = why_unusable(mesh); !wrong.empty()) return bad_input(std::move(wrong));
  const double diagonal_m = mesh.diagonal_m();
  for (const Vec3& v : mesh.vertices_m) {
    if (v.cwiseAbs().maxCoeff() > kLargestLength_m) return bad_input(fmt::format("mesh: a vertex is farther than {} m from 0", kLargestLength_m));
  }
  if (diagonal_m < kSmallestLength_m) return bad_input(fmt::format("mesh: {} m across, must be at least {} m", diagonal_m, kSmallestLength_m));

  const auto executor = parallel::make_executor(ExecutorKind::Tbb, options.threads);
  const TriangleBvh bvh(mesh);
  const SolidAtoms atoms = cut_into_atoms(mesh, bvh, atoms_for(options.depth), *executor);
  SphereTree tree = lay_out_tree(grow(atoms, bvh, diagonal_m, options, *executor));
  measure_protrusions(tree, bvh, *executor);
  return tree;
}

}  // namespace poise
