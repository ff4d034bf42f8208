// SPDX-License-Identifier: MIT
#include <algorithm>

#include <fmt/format.h>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/mesh/mesh_volume.h"
#include "geometry/primitives/rounding.h"
#include "geometry/sphere_tree/node_fit.h"
#include "geometry/sphere_tree/tree_grow.h"
#include "geometry/sphere_tree/tree_layout.h"
#include "geometry/sphere_tree/tree_protrusion.h"
#include "poise/sphere_tree.h"

namespace poise {

using namespace geometry;

Result<SphereTree> build_sphere_tree(const TriangleMesh& mesh, const TreeBuildOptions& options) {
  if (options.depth > kMaxTreeDepth)
    return bad_input(fmt::format("depth = {}, must be from 0 to {}", options.depth, kMaxTreeDepth));
  if (options.threads < 0 || options.threads > 256)
    return bad_input(fmt::format("threads = {}, must be from 0 to 256", options.threads));
  if (std::string wrong = why_unusable(mesh); !wrong.empty()) return bad_input(std::move(wrong));
  const double diagonal_m = mesh.diagonal_m();
  for (const Vec3& v : mesh.vertices_m) {
    if (v.cwiseAbs().maxCoeff() > kLargestLength_m)
      return bad_input(fmt::format("mesh: a vertex is farther than {} m from 0", kLargestLength_m));
  }
  if (diagonal_m < kSmallestLength_m)
    return bad_input(fmt::format("mesh: {} m across, must be at least {} m", diagonal_m, kSmallestLength_m));

  const auto executor = parallel::make_executor(ExecutorKind::Tbb, options.threads);
  const TriangleBvh bvh(mesh, options.solidity);
  double shown = 0;
  const std::function<void(double)> progress = [&](double share) {
    if (options.progress && share >= shown) options.progress(share);
    shown = std::max(shown, share);
  };
  const std::function<bool()> keep_going = [&options] { return !options.stop.stop_requested(); };
  const Error stopped{ErrorKind::Cancelled, "the building of the tree was stopped"};
  progress(0);
  if (!keep_going()) return stopped;
  const std::vector<LooseNode> nodes = grow_tree(mesh, bvh, options, *executor, progress, keep_going);
  if (!keep_going()) return stopped;
  SphereTree tree = flatten_tree(nodes);
  measure_protrusions(tree, bvh, *executor);
  if (!keep_going()) return stopped;
  fit_nodes(tree, mesh, bvh, *executor);
  if (!keep_going()) return stopped;
  progress(1);
  return tree;
}

}  // namespace poise
