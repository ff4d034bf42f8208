// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/tree_protrusion.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/primitives/rounding.h"

namespace poise::geometry {
namespace {

/// Tolerance far above the rounding of the terms of a bound.
constexpr double kRoundingRoom = 1e-8;

}  // namespace

std::vector<std::vector<NodeIndex>> overlapping_nodes(const SphereTree& tree, const std::vector<NodeIndex>& nodes) {
  std::vector<double> low_m(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    low_m[i] = tree.sphere(nodes[i]).center_m.x() - tree.sphere(nodes[i]).radius_m;
  std::vector<std::size_t> by_low(nodes.size());
  std::iota(by_low.begin(), by_low.end(), std::size_t{0});
  std::ranges::stable_sort(by_low, {}, [&](std::size_t i) { return low_m[i]; });
  std::vector<std::vector<std::size_t>> points(nodes.size());
  for (std::size_t s = 0; s < by_low.size(); ++s) {
    const Sphere own = tree.sphere(nodes[by_low[s]]);
    const double high_m = own.center_m.x() + own.radius_m;
    for (std::size_t t = s + 1; t < by_low.size() && low_m[by_low[t]] < high_m; ++t) {
      const Sphere theirs = tree.sphere(nodes[by_low[t]]);
      const double reach_m = own.radius_m + theirs.radius_m;
      if ((own.center_m - theirs.center_m).squaredNorm() >= reach_m * reach_m) continue;
      points[by_low[s]].push_back(by_low[t]);
      points[by_low[t]].push_back(by_low[s]);
    }
  }
  std::vector<std::vector<NodeIndex>> overlapping(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    std::ranges::sort(points[i]);
    for (const std::size_t place : points[i]) overlapping[i].push_back(nodes[place]);
  }
  return overlapping;
}

bool hidden_by(const SphereTree& tree, const std::vector<NodeIndex>& others, const Vec3& point) {
  return std::ranges::any_of(others, [&](NodeIndex other) {
    const Sphere sphere = tree.sphere(other);
    return (sphere.center_m - point).squaredNorm() < sphere.radius_m * sphere.radius_m;
  });
}

void measure_protrusions(SphereTree& tree, const ObjectQueries& object, const ProtrusionOptions& options,
                         parallel::Executor& executor) {
  // The deepest level is all leaves.
  const int levels = options.leaves_are_surface ? tree.depth() : tree.depth() + 1;
  for (Level level = 0; level < levels && !options.stop.stop_requested(); ++level) {
    const std::vector<NodeIndex> nodes = tree.nodes_at(level);
    const auto overlapping = overlapping_nodes(tree, nodes);
    parallel::parallel_for(executor, nodes.size(), 1, [&](std::size_t begin, std::size_t end, int) {
      std::vector<Sphere> others;
      for (std::size_t i = begin; i < end && !options.stop.stop_requested(); ++i) {
        if (options.leaves_are_surface && tree.child_count[nodes[i]] == 0) continue;
        others.clear();
        for (const NodeIndex other : overlapping[i]) others.push_back(tree.sphere(other));
        const Sphere own = tree.sphere(nodes[i]);
        const SphereProtrusion bound = sphere_protrusion(own, others, object, options.tolerance_m);
        const double room = kRoundingRoom * own.radius_m * 1e-4;
        const auto stored = [room](double value_m) {
          return value_m > 0 ? round_up(value_m * (1 + kRoundingRoom) + room) : 0.0F;
        };
        float& max_m = tree.protrusion_max_m[nodes[i]];
        float& mean_m = tree.protrusion_mean_m[nodes[i]];
        max_m = std::max(max_m, stored(bound.max_m));
        mean_m = std::max(mean_m, stored(bound.mean_m));
      }
    });
  }
}

void measure_protrusions(SphereTree& tree, const TriangleBvh& bvh, parallel::Executor& executor,
                         const std::stop_token& stop) {
  ObjectQueries object;
  object.nearest = [&bvh](const Vec3& point, std::uint32_t guess) {
    const TriangleBvh::Closest closest = bvh.closest_from(point, guess);
    if (!bvh.inside(point)) return ObjectBall{closest.point_m, 0, closest.triangle};
    return ObjectBall{point, std::sqrt(closest.squared_distance_m2), closest.triangle};
  };
  object.to_piece = [&bvh](std::uint32_t triangle, const Vec3& point) {
    return (closest_on_triangle(point, bvh.corners(triangle)) - point).norm();
  };
  measure_protrusions(tree, object, {.tolerance_m = 2e-4 * bvh.diagonal_m(), .stop = stop}, executor);
}

}  // namespace poise::geometry
