// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
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
  const double at = std::clamp(x_m * cells_per_meter, -kFarthestCell, kFarthestCell);
  const auto cell = static_cast<std::int32_t>(at);  // towards zero
  return cell - static_cast<std::int32_t>(static_cast<double>(cell) > at);
}

/// What a cell's place in memory is made of: the sum of what each of its coordinates gives.
struct BlockKey {
  std::uint64_t hash = 0;    ///< of its block
  std::uint32_t inside = 0;  ///< its place in the block
  std::uint32_t tag = 0;     ///< blocks of equal tag are the same, or of cells that are 1000 cells apart

  static BlockKey of_x(std::int32_t x) {
    return {block(x, 4) * 0x9e3779b97f4a7c15U, static_cast<std::uint32_t>(x & 15), low_bits(x, 4) << 16U};
  }
  static BlockKey of_y(std::int32_t y) {
    return {block(y, 2) * 0xc2b2ae3d27d4eb4fU, static_cast<std::uint32_t>((y & 3) << 4), low_bits(y, 2) << 8U};
  }
  static BlockKey of_z(std::int32_t z) {
    return {block(z, 2) * 0x165667b19e3779f9U, static_cast<std::uint32_t>((z & 3) << 6), low_bits(z, 2)};
  }
  static BlockKey of_grid(std::int32_t grid) {
    return {static_cast<std::uint64_t>(grid) * 0x27d4eb2f165667c5U, 0, static_cast<std::uint32_t>(grid) << 24U};
  }
  friend BlockKey operator+(const BlockKey& a, const BlockKey& b) {
    return {a.hash + b.hash, a.inside + b.inside, a.tag + b.tag};
  }
  /// If there are block_mask + 1 blocks, a power of two.
  [[nodiscard]] std::uint64_t bucket(std::uint64_t block_mask) const {
    return ((hash >> 32U) & block_mask) * kBlockCells + inside;
  }

 private:
  static std::uint64_t block(std::int32_t at, int bits) { return static_cast<std::uint64_t>(at >> bits); }
  static std::uint32_t low_bits(std::int32_t at, int bits) { return static_cast<std::uint32_t>(at >> bits) & 0xffU; }
};

inline BlockKey block_key(std::int32_t x, std::int32_t y, std::int32_t z, std::int32_t grid) {
  return BlockKey::of_x(x) + BlockKey::of_y(y) + BlockKey::of_z(z) + BlockKey::of_grid(grid);
}

/// The bucket of a cell, if there are block_mask + 1 blocks, a power of two.
inline std::uint64_t bucket_of(std::int32_t x, std::int32_t y, std::int32_t z, std::int32_t grid,
                               std::uint64_t block_mask) {
  return block_key(x, y, z, grid).bucket(block_mask);
}

/// The grid of balls of up to a metre across.
inline constexpr int kUnitGrid = 24;

/// The grid of a ball: those whose diameters lie within one octave, up to 2^(grid - kUnitGrid) m, share it.
inline int grid_of(double radius_m) {
  constexpr double kLeastM = 1e-6;
  // The exponent of a number in [0.5, 1) is 0.
  const auto bits = std::bit_cast<std::uint64_t>(std::max(2.0 * radius_m, kLeastM));
  return std::clamp(static_cast<int>(bits >> 52U) - 1022 + kUnitGrid, 0, 63);
}

}  // namespace poise::collision
