// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace poise::geometry {

/// One side of one triangle.
struct EdgeUse {
  std::uint32_t low, high;  ///< the vertices at its ends, low < high
  std::uint32_t triangle;   ///< the triangle of this side
  std::int32_t direction;   ///< 1 if the triangle runs from low to high, else -1
  [[nodiscard]] std::uint64_t edge() const { return std::uint64_t{low} << 32U | high; }
};

/// The sides of all triangles, sorted by edge; those of one edge in the order of the triangles. No triangle may name a
/// vertex twice.
std::vector<EdgeUse> edge_uses(std::span<const std::array<std::uint32_t, 3>> triangles);

/// Calls visit(uses) with the sides of each edge, edge after edge. `uses` must come from edge_uses.
template <class Visit>
void for_each_edge(std::span<const EdgeUse> uses, Visit&& visit) {
  for (std::size_t begin = 0; begin < uses.size();) {
    std::size_t end = begin + 1;
    while (end < uses.size() && uses[end].edge() == uses[begin].edge()) ++end;
    visit(uses.subspan(begin, end - begin));
    begin = end;
  }
}

/// Sum of the directions; 0 if equally many triangles run each way, as at each edge of a closed surface.
inline std::int32_t edge_balance(std::span<const EdgeUse> uses) {
  std::int32_t balance = 0;
  for (const EdgeUse& use : uses) balance += use.direction;
  return balance;
}

/// Disjoint sets of the numbers from 0 on (Tarjan's union-find with path halving; the lowest number represents a set).
/// Invariant: leader_[i] <= i.
class JoinedSets {
 public:
  explicit JoinedSets(std::size_t count);
  std::uint32_t leader(std::uint32_t i);
  void join(std::uint32_t a, std::uint32_t b);

 private:
  std::vector<std::uint32_t> leader_;
};

}  // namespace poise::geometry
