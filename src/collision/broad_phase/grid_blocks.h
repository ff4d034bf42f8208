// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

/// Where the cells of the broad phase's grids lie in memory.
///
/// Buckets of neighbouring cells lie side by side, in blocks of 16 x 4 x 4 that are placed by a hash: a search of
/// neighbours reads what lies together, and no arrangement of bodies puts many cells into one bucket.
namespace poise::collision {

inline constexpr double kFarthestCell = 1e9;
inline constexpr std::int32_t kBlockRow = 16;
inline constexpr std::uint64_t kBlockCells = std::uint64_t{kBlockRow} * 4 * 4;

inline std::int32_t cell_of(double x_m, double cells_per_meter) {
  return static_cast<std::int32_t>(std::clamp(std::floor(x_m * cells_per_meter), -kFarthestCell, kFarthestCell));
}

/// The bucket of a cell, if there are block_mask + 1 blocks, a power of two.
inline std::uint64_t bucket_of(std::int32_t x, std::int32_t y, std::int32_t z, std::int32_t grid,
                               std::uint64_t block_mask) {
  const auto block = [](std::int32_t at, int bits) { return static_cast<std::uint64_t>(at >> bits); };
  const std::uint64_t hash = block(x, 4) * 0x9e3779b97f4a7c15U + block(y, 2) * 0xc2b2ae3d27d4eb4fU +
                             block(z, 2) * 0x165667b19e3779f9U + static_cast<std::uint64_t>(grid) * 0x27d4eb2f165667c5U;
  const auto inside = static_cast<std::uint64_t>((z & 3) << 6 | (y & 3) << 4 | (x & 15));
  return ((hash >> 32U) & block_mask) * kBlockCells + inside;
}

/// The grid of balls of up to a metre across.
inline constexpr int kUnitGrid = 24;

/// The grid of a ball: those whose diameters lie within one octave, up to 2^(grid - kUnitGrid) m, share it.
inline int grid_of(double radius_m) {
  constexpr double kLeastM = 1e-6;
  int exponent = 0;
  std::frexp(std::max(2.0 * radius_m, kLeastM), &exponent);
  return std::clamp(exponent + kUnitGrid, 0, 63);
}

}  // namespace poise::collision
