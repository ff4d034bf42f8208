// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include <fmt/format.h>

#include "geometry/mesh/mesh_volume.h"
#include "geometry/primitives/enclosing_ball.h"
#include "geometry/primitives/rounding.h"
#include "geometry/sphere_tree/nearest_leaf.h"
#include "geometry/sphere_tree/node_fit.h"
#include "geometry/sphere_tree/tree_layout.h"
#include "geometry/sphere_tree/tree_of_spheres.h"
#include "geometry/sphere_tree/tree_protrusion.h"
#include "poise/sphere_tree.h"

namespace poise {
namespace {

using geometry::LooseNode;
using Group = std::vector<std::uint32_t>;

/// Accepted error of protrusions, as a share of the root's radius. Chosen.
constexpr double kProtrusionWithin = 4e-4;
/// Fewer take less time than to have threads ready.
constexpr std::size_t kFewSpheres = 256;

std::size_t capacity_below(Level levels) {
  std::size_t capacity = 1;
  for (Level l = 0; l < levels; ++l) capacity *= kTreeBranching;
  return capacity;
}

Vec3 mean_center(std::span<const Sphere> spheres, const Group& group) {
  Vec3 sum = Vec3::Zero();
  for (const std::uint32_t i : group) sum += spheres[i].center_m;
  return sum / static_cast<double>(group.size());
}

Sphere ball_of(std::span<const Sphere> spheres, const Group& group) {
  std::vector<Sphere> members;
  members.reserve(group.size());
  for (const std::uint32_t i : group) members.push_back(spheres[i]);
  return geometry::enclosing_ball_of_balls(members);
}

/// Starts with the sphere farthest from the middle, then repeatedly adds the one farthest from those chosen; ties go to
/// the first.
std::vector<Vec3> spread_seeds(std::span<const Sphere> spheres, const Group& group) {
  std::vector<Vec3> seeds;
  std::vector<double> nearest(group.size(), std::numeric_limits<double>::infinity());
  Vec3 last = mean_center(spheres, group);
  for (std::uint32_t k = 0; k < kTreeBranching; ++k) {
    std::size_t farthest = 0;
    double largest = -1;
    for (std::size_t i = 0; i < group.size(); ++i) {
      const double d = (spheres[group[i]].center_m - last).squaredNorm();
      nearest[i] = k <= 1 ? d : std::min(nearest[i], d);
      if (nearest[i] > largest) {
        largest = nearest[i];
        farthest = i;
      }
    }
    last = spheres[group[farthest]].center_m;
    seeds.push_back(last);
  }
  return seeds;
}

std::vector<Group> assign(std::span<const Sphere> spheres, const Group& group, const std::vector<Vec3>& centers) {
  std::vector<Group> groups(centers.size());
  for (const std::uint32_t i : group) {
    std::size_t best = 0;
    for (std::size_t k = 1; k < centers.size(); ++k) {
      if ((spheres[i].center_m - centers[k]).squaredNorm() < (spheres[i].center_m - centers[best]).squaredNorm())
        best = k;
    }
    groups[best].push_back(i);
  }
  return groups;
}

/// Halves the group along its widest axis repeatedly into eight; the tree is never deeper than needed.
std::vector<Group> split_evenly(std::span<const Sphere> spheres, const Group& group) {
  std::vector<Group> groups{group};
  for (int round = 0; round < 3; ++round) {
    std::vector<Group> halves;
    for (Group& whole : groups) {
      if (whole.size() < 2) {
        halves.push_back(std::move(whole));
        continue;
      }
      Vec3 low = spheres[whole[0]].center_m;
      Vec3 high = low;
      for (const std::uint32_t i : whole) {
        low = low.cwiseMin(spheres[i].center_m);
        high = high.cwiseMax(spheres[i].center_m);
      }
      int axis = 0;
      (high - low).maxCoeff(&axis);
      std::ranges::stable_sort(whole, {}, [&](std::uint32_t i) { return spheres[i].center_m[axis]; });
      const auto middle = whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2);
      halves.emplace_back(whole.begin(), middle);
      halves.emplace_back(middle, whole.end());
    }
    groups = std::move(halves);
  }
  return groups;
}

/// At most eight groups, none larger than `capacity`.
std::vector<Group> split(std::span<const Sphere> spheres, const Group& group, std::size_t capacity) {
  std::vector<Vec3> centers = spread_seeds(spheres, group);
  std::vector<Group> groups;
  for (int round = 0; round < 10; ++round) {
    groups = assign(spheres, group, centers);
    for (std::size_t k = 0; k < groups.size(); ++k) {
      if (!groups[k].empty()) centers[k] = mean_center(spheres, groups[k]);
    }
  }
  std::erase_if(groups, [](const Group& g) { return g.empty(); });
  const bool fits =
      groups.size() > 1 && std::ranges::all_of(groups, [&](const Group& g) { return g.size() <= capacity; });
  return fits ? groups : split_evenly(spheres, group);
}

std::uint32_t add_node(std::span<const Sphere> spheres, const Group& group, Level levels,
                       std::vector<LooseNode>& nodes) {
  const auto index = static_cast<std::uint32_t>(nodes.size());
  nodes.emplace_back();
  const Sphere ball = ball_of(spheres, group);
  nodes[index].center_m = geometry::to_float(ball.center_m);
  if (group.size() == 1) {
    nodes[index].radius_m = static_cast<float>(ball.radius_m);
    return index;
  }
  const Vec3 center = nodes[index].center_m.cast<double>();
  double reach_m = 0;
  for (const std::uint32_t i : group) {
    const Vec3 member = geometry::to_float(spheres[i].center_m).cast<double>();
    reach_m = std::max(reach_m, (member - center).norm() + geometry::stored_as_float(spheres[i].radius_m));
  }
  nodes[index].radius_m = geometry::covering_radius(reach_m, reach_m);
  std::vector<Group> groups;
  if (group.size() <= kTreeBranching) {
    for (const std::uint32_t i : group) groups.push_back({i});
  } else {
    groups = split(spheres, group, capacity_below(static_cast<Level>(levels - 1)));
  }
  for (const Group& child : groups) {
    const std::uint32_t added = add_node(spheres, child, static_cast<Level>(levels - 1), nodes);
    nodes[index].children.push_back(added);
  }
  return index;
}

/// The leaves as the object from which the nodes above protrude.
geometry::ObjectQueries leaves_of(const SphereTree& tree) {
  geometry::ObjectQueries object;
  object.nearest = [&tree](const Vec3& point, std::uint32_t) {
    const Sphere leaf = tree.sphere(geometry::nearest_leaf(tree, point).node);
    return geometry::ObjectBall{leaf.center_m, leaf.radius_m};
  };
  return object;
}

Result<SphereTree> build_union(std::span<const Sphere> spheres, const UnionTreeOptions& options) {
  Level levels = 0;
  while (capacity_below(levels) < spheres.size()) ++levels;
  Group all(spheres.size());
  std::iota(all.begin(), all.end(), 0U);
  std::vector<LooseNode> nodes;
  add_node(spheres, all, levels, nodes);
  SphereTree tree = geometry::flatten_tree(nodes);

  const bool alone = spheres.size() < kFewSpheres;
  const auto executor =
      parallel::make_executor(alone ? ExecutorKind::Serial : ExecutorKind::Tbb, alone ? 1 : options.threads);
  const double tolerance_m = kProtrusionWithin * tree.sphere(0).radius_m;
  geometry::measure_protrusions(
      tree, leaves_of(tree), {.tolerance_m = tolerance_m, .leaves_are_surface = true, .stop = options.stop}, *executor);
  if (options.stop.stop_requested()) return Error{ErrorKind::Cancelled, "the building of the tree was stopped"};
  geometry::fit_nodes_to_leaves(tree);
  return tree;
}

}  // namespace

std::string geometry::why_not_spheres(std::span<const Sphere> spheres) {
  if (spheres.empty()) return "spheres: there is none, at least one is needed";
  if (spheres.size() > kMaxUnionSpheres) {
    return fmt::format("spheres: {} of them, at most {} are possible", spheres.size(), kMaxUnionSpheres);
  }
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Vec3& c = spheres[i].center_m;
    if (!c.allFinite() || c.cwiseAbs().maxCoeff() > geometry::kLargestLength_m) {
      return fmt::format("spheres[{}].center_m = ({}, {}, {}), must be finite and at most {} m from 0", i, c.x(), c.y(),
                         c.z(), geometry::kLargestLength_m);
    }
    const double r = spheres[i].radius_m;
    if (!(r >= geometry::kSmallestLength_m && r <= geometry::kLargestLength_m)) {
      return fmt::format("spheres[{}].radius_m = {}, must be > 0 (from {} to {} m)", i, r, geometry::kSmallestLength_m,
                         geometry::kLargestLength_m);
    }
  }
  return {};
}

Result<SphereTree> tree_of_spheres(std::span<const Sphere> spheres, const UnionTreeOptions& options) {
  if (std::string wrong = geometry::why_not_threads(options.threads); !wrong.empty())
    return bad_input(std::move(wrong));
  if (std::string wrong = geometry::why_not_spheres(spheres); !wrong.empty()) return bad_input(std::move(wrong));
  return geometry::union_tree(spheres, options);
}

Result<SphereTree> geometry::union_tree(std::span<const Sphere> spheres, const UnionTreeOptions& options) {
  return build_union(spheres, options);
}

}  // namespace poise
