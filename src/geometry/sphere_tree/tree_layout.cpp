// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/tree_layout.h"

#include <algorithm>

#include "geometry/primitives/rounding.h"
#include "geometry/sphere_tree/node_fit.h"

namespace poise {

std::vector<NodeIndex> SphereTree::nodes_at(Level level) const {
  std::vector<NodeIndex> nodes;
  const std::size_t levels = level_begin.empty() ? 0 : level_begin.size() - 1;
  for (std::size_t l = 0; l < levels && l <= level; ++l) {
    for (NodeIndex node = level_begin[l]; node < level_begin[l + 1]; ++node) {
      if (l == level || child_count[node] == 0) nodes.push_back(node);
    }
  }
  return nodes;
}

}  // namespace poise

namespace poise::geometry {

SphereTree flatten_tree(const std::vector<LooseNode>& nodes) {
  SphereTree tree;
  std::vector<std::uint32_t> level{0};
  while (!level.empty()) {
    tree.level_begin.push_back(static_cast<NodeIndex>(tree.x_m.size()));
    std::vector<std::uint32_t> next;
    auto next_child = static_cast<NodeIndex>(tree.x_m.size() + level.size());
    for (const std::uint32_t index : level) {
      const LooseNode& node = nodes[index];
      const auto place = static_cast<NodeIndex>(tree.x_m.size());
      tree.x_m.push_back(node.center_m.x());
      tree.y_m.push_back(node.center_m.y());
      tree.z_m.push_back(node.center_m.z());
      tree.radius_m.push_back(node.radius_m);
      tree.first_child.push_back(node.children.empty() ? place : next_child);
      tree.child_count.push_back(static_cast<std::uint8_t>(node.children.size()));
      next_child += static_cast<NodeIndex>(node.children.size());
      next.insert(next.end(), node.children.begin(), node.children.end());
    }
    level = std::move(next);
  }
  tree.level_begin.push_back(static_cast<NodeIndex>(tree.x_m.size()));
  tree.protrusion_max_m.assign(tree.node_count(), 0.0F);
  tree.protrusion_mean_m.assign(tree.node_count(), 0.0F);
  pad_tree(tree);
  fit_nodes_to_themselves(tree);
  return tree;
}

void pad_tree(SphereTree& tree) {
  const std::size_t size = tree.node_count() + kTreeBranching;
  for (auto* array :
       {&tree.x_m, &tree.y_m, &tree.z_m, &tree.radius_m, &tree.protrusion_max_m, &tree.protrusion_mean_m}) {
    array->resize(size, 0.0F);
  }
  tree.fit.resize(size);
  tree.first_child.resize(size, 0);
  tree.child_count.resize(size, 0);
}

void recenter_tree(SphereTree& tree, const Vec3& offset_m, bool leaves_are_surface) {
  const std::size_t count = tree.node_count();
  std::vector<double> errors_m(count);
  double largest_leaf_error_m = 0;
  for (NodeIndex node = 0; node < count; ++node) {
    const Vec3 exact = tree.sphere(node).center_m - offset_m;
    const Eigen::Vector3f rounded = to_float(exact);
    errors_m[node] = (rounded.cast<double>() - exact).norm();
    if (tree.child_count[node] == 0) largest_leaf_error_m = std::max(largest_leaf_error_m, errors_m[node]);
    tree.x_m[node] = rounded.x();
    tree.y_m[node] = rounded.y();
    tree.z_m[node] = rounded.z();
    NodeFit& fit = tree.fit[node];
    const Eigen::Vector3f fitted = to_float(
        Vec3(static_cast<double>(fit.x_m), static_cast<double>(fit.y_m), static_cast<double>(fit.z_m)) - offset_m);
    fit.x_m = fitted.x();
    fit.y_m = fitted.y();
    fit.z_m = fitted.z();
  }
  for (NodeIndex node = 0; node < count; ++node) {
    const bool leaf = tree.child_count[node] == 0;
    if (leaves_are_surface && leaf) continue;
    const double growth_m = errors_m[node] + (leaves_are_surface ? largest_leaf_error_m : 0.0);
    if (growth_m == 0) continue;
    const auto radius_m = static_cast<double>(tree.radius_m[node]);
    tree.radius_m[node] = covering_radius(radius_m + growth_m, radius_m);
  }
}

}  // namespace poise::geometry
