// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/nearest_leaf.h"

#include <cmath>

namespace poise::geometry {
namespace {

double distance_to(const SphereTree& tree, NodeIndex node, const Vec3& point) {
  const Sphere sphere = tree.sphere(node);
  return (sphere.center_m - point).norm() - sphere.radius_m;
}

// To the leaf that is reached by the nearest child of each node.
double near_leaf_m(const SphereTree& tree, const Vec3& point) {
  NodeIndex node = 0;
  while (tree.child_count[node] > 0) {
    NodeIndex nearest = tree.first_child[node];
    double least = distance_to(tree, nearest, point);
    for (NodeIndex c = 1; c < tree.child_count[node]; ++c) {
      const double distance = distance_to(tree, tree.first_child[node] + c, point);
      if (distance >= least) continue;
      least = distance;
      nearest = tree.first_child[node] + c;
    }
    node = nearest;
  }
  return distance_to(tree, node, point);
}

void search(const SphereTree& tree, NodeIndex node, const Vec3& point, NearestLeaf& best) {
  const double distance_m = distance_to(tree, node, point);
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
  // That leaf itself is still to be found, if none comes before it.
  best.distance_m = std::nextafter(near_leaf_m(tree, point), std::numeric_limits<double>::infinity());
  search(tree, 0, point, best);
  return best;
}

}  // namespace poise::geometry
