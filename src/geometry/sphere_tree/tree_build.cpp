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
  if (options.preset > TreePreset::Best)
    return bad_input(fmt::format("preset = {}, must be one of TreePreset", static_cast<int>(options.preset)));
  if (options.solidity > Solidity::Shell)
    return bad_input(fmt::format("solidity = {}, must be one of Solidity", static_cast<int>(options.solidity)));
  if (std::string wrong = why_not_threads(options.threads); !wrong.empty()) return bad_input(std::move(wrong));
  if (std::string wrong = why_unusable(mesh); !wrong.empty()) return bad_input(std::move(wrong));

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
  measure_protrusions(tree, bvh, *executor, options.stop);
  if (!keep_going()) return stopped;
  fit_nodes(tree, mesh, bvh, *executor);
  if (!keep_going()) return stopped;
  progress(1);
  return tree;
}

}  // namespace poise
