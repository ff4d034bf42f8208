// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/tree_check.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

namespace poise::geometry {
namespace {

// A root may be as wide as a box with corners at the coordinate limit, and its centre as far out.
constexpr float kFarthest_m = 4e9F;

std::string why_not_levels(const SphereTree& tree) {
  const std::size_t levels = tree.level_begin.size() - 1;
  if (levels > kMaxTreeDepth + 1U)
    return fmt::format("level_begin: {} levels, at most {} are possible", levels, kMaxTreeDepth + 1);
  if (tree.level_begin[0] != 0 || tree.level_begin[1] != 1)
    return fmt::format("level_begin: begins with {}, {}, must be 0, 1", tree.level_begin[0], tree.level_begin[1]);
  for (std::size_t level = 0; level < levels; ++level) {
    const NodeIndex begin = tree.level_begin[level];
    const NodeIndex end = tree.level_begin[level + 1];
    if (begin >= end) return fmt::format("level_begin[{}] = {}, must be above {}", level + 1, end, begin);
  }
  return {};
}

std::string why_not_arrays(const SphereTree& tree) {
  const std::size_t needed = tree.node_count() + kTreeBranching;
  const std::pair<const char*, std::size_t> sizes[] = {{"x_m", tree.x_m.size()},
                                                       {"y_m", tree.y_m.size()},
                                                       {"z_m", tree.z_m.size()},
                                                       {"radius_m", tree.radius_m.size()},
                                                       {"protrusion_max_m", tree.protrusion_max_m.size()},
                                                       {"protrusion_mean_m", tree.protrusion_mean_m.size()},
                                                       {"fit", tree.fit.size()},
                                                       {"first_child", tree.first_child.size()},
                                                       {"child_count", tree.child_count.size()}};
  for (const auto& [name, size] : sizes) {
    if (size < needed) return fmt::format("{} has {} entries, must have {} (nodes and padding)", name, size, needed);
  }
  return {};
}

std::string why_not_children(const SphereTree& tree) {
  const std::size_t levels = tree.level_begin.size() - 1;
  for (std::size_t level = 0; level < levels; ++level) {
    const NodeIndex end = tree.level_begin[level + 1];
    std::size_t next_child = end;
    for (NodeIndex node = tree.level_begin[level]; node < end; ++node) {
      const std::uint32_t children = tree.child_count[node];
      if (children > kTreeBranching)
        return fmt::format("child_count[{}] = {}, must be at most {}", node, children, kTreeBranching);
      const std::size_t first = children == 0 ? node : next_child;
      if (tree.first_child[node] != first)
        return fmt::format("first_child[{}] = {}, must be {}", node, tree.first_child[node], first);
      next_child += children;
    }
    const std::size_t below = level + 1 < levels ? tree.level_begin[level + 2] : end;
    if (next_child != below)
      return fmt::format("child_count: level {} has {} children, must have {}, as the next level has nodes", level,
                         next_child - end, below - end);
  }
  return {};
}

std::string why_not_numbers(const SphereTree& tree, NodeIndex node) {
  const auto outside = [&](const char* name, float value, const char* rule) {
    return fmt::format("{}[{}] = {}, must be {}{} m", name, node, value, rule, kFarthest_m);
  };
  const auto within = [](float value, float most) { return std::abs(value) <= most; };
  const std::pair<const char*, float> coordinates[] = {
      {"x_m", tree.x_m[node]}, {"y_m", tree.y_m[node]}, {"z_m", tree.z_m[node]}};
  for (const auto& [name, value] : coordinates) {
    if (!within(value, kFarthest_m)) return outside(name, value, "within ");
  }
  const std::pair<const char*, float> lengths[] = {{"radius_m", tree.radius_m[node]},
                                                   {"protrusion_max_m", tree.protrusion_max_m[node]},
                                                   {"protrusion_mean_m", tree.protrusion_mean_m[node]}};
  for (const auto& [name, value] : lengths) {
    if (!(value >= 0 && value <= kFarthest_m)) return outside(name, value, "from 0 to ");
  }
  const NodeFit& fit = tree.fit[node];
  for (const float length_m : {fit.x_m, fit.y_m, fit.z_m, fit.radius_m, fit.core_m}) {
    if (!within(length_m, 8 * kFarthest_m))
      return fmt::format("fit[{}] has the length {}, must be within {} m", node, length_m, 8 * kFarthest_m);
  }
  if (!(std::isfinite(fit.variance_m2) && fit.variance_m2 >= 0))
    return fmt::format("fit[{}].variance_m2 = {}, must be finite and >= 0", node, fit.variance_m2);
  return {};
}

}  // namespace

std::string why_not_tree(const SphereTree& tree) {
  if (tree.level_begin.size() < 2) return "tree: there is no node, at least one is needed";
  for (const auto& check : {why_not_levels, why_not_arrays, why_not_children}) {
    if (std::string wrong = check(tree); !wrong.empty()) return "tree: " + wrong;
  }
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    if (std::string wrong = why_not_numbers(tree, node); !wrong.empty()) return "tree: " + wrong;
  }
  return {};
}

}  // namespace poise::geometry
