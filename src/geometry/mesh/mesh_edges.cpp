// SPDX-License-Identifier: MIT
#include "geometry/mesh/mesh_edges.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace poise::geometry {

std::vector<EdgeUse> edge_uses(std::span<const std::array<std::uint32_t, 3>> triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = triangles[t][i];
      const std::uint32_t to = triangles[t][(i + 1) % 3];
      uses.push_back({std::min(from, to), std::max(from, to), t, from < to ? 1 : -1});
    }
  }
  // No two sides of a triangle are the same edge, so the order is unique.
  std::ranges::sort(uses, {}, [](const EdgeUse& use) { return std::tuple(use.edge(), use.triangle); });
  return uses;
}

JoinedSets::JoinedSets(std::size_t count) : leader_(count) { std::iota(leader_.begin(), leader_.end(), 0U); }

std::uint32_t JoinedSets::leader(std::uint32_t i) {
  while (leader_[i] != i) {
    leader_[i] = leader_[leader_[i]];
    i = leader_[i];
  }
  return i;
}

void JoinedSets::join(std::uint32_t a, std::uint32_t b) {
  a = leader(a);
  b = leader(b);
  leader_[std::max(a, b)] = std::min(a, b);
}

}  // namespace poise::geometry
