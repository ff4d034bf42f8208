// SPDX-License-Identifier: MIT
#include "geometry/tree_protrusion.h"

#include <algorithm>

#include "geometry/sampling.h"

namespace poise::geometry {

std::vector<std::vector<NodeIndex>> overlapping_nodes(const SphereTree& tree, const std::vector<NodeIndex>& nodes,
                                                      parallel::Executor& executor) {
  std::vector<std::vector<NodeIndex>> overlapping(nodes.size());
  parallel::parallel_for(executor, nodes.size(), 16, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const Sphere own = tree.sphere(nodes[i]);
      for (const NodeIndex other : nodes) {
        if (other == nodes[i]) continue;
        const Sphere theirs = tree.sphere(other);
        const double reach_m = own.radius_m + theirs.radius_m;
        if ((own.center_m - theirs.center_m).squaredNorm() < reach_m * reach_m) overlapping[i].push_back(other);
      }
    }
  });
  return overlapping;
}

bool hidden_by(const SphereTree& tree, const std::vector<NodeIndex>& others, const Vec3& point) {
  return std::ranges::any_of(others, [&](NodeIndex other) {
    const Sphere sphere = tree.sphere(other);
    return (sphere.center_m - point).squaredNorm() < sphere.radius_m * sphere.radius_m;
  });
}

void measure_protrusions(SphereTree& tree, const OutsideDistance& outside_m, int samples, parallel::Executor& executor) {
  const std::vector<Vec3> directions = even_directions(samples);
  for (Level level = 0; level <= tree.depth(); ++level) {
    const std::vector<NodeIndex> nodes = tree.nodes_at(level);
    const auto overlapping = overlapping_nodes(tree, nodes, executor);
    parallel::parallel_for(executor, nodes.size(), 4, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) {
        const Sphere sphere = tree.sphere(nodes[i]);
        double largest_m = 0;
        double sum_m = 0;
        int exposed = 0;
        for (const Vec3& direction : directions) {
          const Vec3 point = sphere.center_m + sphere.radius_m * direction;
          if (hidden_by(tree, overlapping[i], point)) continue;
          const double distance_m = outside_m(point);
          largest_m = std::max(largest_m, distance_m);
          sum_m += distance_m;
          ++exposed;
        }
        const double mean_m = exposed > 0 ? sum_m / exposed : 0.0;
        float& stored_max_m = tree.protrusion_max_m[nodes[i]];
        float& stored_mean_m = tree.protrusion_mean_m[nodes[i]];
        stored_max_m = std::max(stored_max_m, static_cast<float>(largest_m));
        stored_mean_m = std::max(stored_mean_m, static_cast<float>(mean_m));
      }
    });
  }
}

}  // namespace poise::geometry
