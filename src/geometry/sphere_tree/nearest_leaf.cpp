// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/nearest_leaf.h"

namespace poise::geometry {
namespace {

void search(const SphereTree& tree, NodeIndex node, const Vec3& point, NearestLeaf& best) {
  const Sphere sphere = tree.sphere(node);
  const double distance_m = (sphere.center_m - point).norm() - sphere.radius_m;
  if (distance_m >= best.distance_m) return;
  if (tree.child_count[node] == 0) {
    best = {distance_m, node};
    return;
  }
  for (NodeIndex c = 0; c < tree.child_count[node]; ++c) search(tree, tree.first_child[node] + c, point, best);
}

}  // namespace

NearestLeaf nearest_leaf(const SphereTree& tree, const Vec3& point) {
  NearestLeaf best;
  search(tree, 0, point, best);
  return best;
}

}  // namespace poise::geometry
