// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace poise::solver {

/// The two bodies of a row, for coloring.h.
struct Edge {
  std::uint32_t a = 0, b = 0;
  bool dynamic_a = true, dynamic_b = true;
  std::uint8_t rank = 0;  ///< below kRanks: rank_of() of its contact points
  [[nodiscard]] bool grounded() const { return !(dynamic_a && dynamic_b); }
};

/// Colours that a body has room for, a bit each in a word.
inline constexpr std::uint32_t kColors = 64;
/// The last of them, for rows with a body that is not dynamic: an iteration ends with them, so that what does not
/// yield holds whatever the rows before them left.
inline constexpr std::uint32_t kGroundColors = 8;
inline constexpr std::uint32_t kRanks = 8;

/// The rank of a row with so many contact points: as many, or the last one.
inline std::uint8_t rank_of(std::uint8_t point_count) {
  constexpr std::uint8_t kLast = kRanks - 1;
  return point_count < kLast ? point_count : kLast;
}

/// The colours that an edge may not have, as bits.
inline std::uint64_t colors_of_others(const Edge& edge) {
  constexpr std::uint64_t kGrounded = ~std::uint64_t{0} << (kColors - kGroundColors);
  return edge.grounded() ? ~kGrounded : kGrounded;
}

}  // namespace poise::solver
