// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/broad_phase/grid_blocks.h"
#include "parallel/executor.h"
#include "parallel/unset_vector.h"

namespace poise::collision {

/// The bounds of bodies that do not move, kept from step to step in a hashed grid for each power of two of size. To put
/// one in or take it out takes a time that does not depend on how many there are, and so does a search but for what it
/// finds. Answers depend on what was put in and taken out, not on threads.
class RestingGrid {
 public:
  /// Takes `taken` out, which must be in, and puts `put` in, of which none may be in then. A slot may be in both:
  /// moved.
  void change(std::span<const std::uint32_t> taken, std::span<const MotionBound> put, parallel::Executor& executor);
  /// Memory for bounds of so many slots.
  void reserve(std::size_t slots) { entries_.reserve(slots); }
  void clear();
  [[nodiscard]] bool holds(std::uint32_t slot) const {
    return slot < entries_.size() && entries_[slot].bucket != kNone;
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Another number after each change.
  [[nodiscard]] std::uint64_t version() const { return version_; }

  struct Entry {
    Vec3 center_m;
    double radius_m;
    std::uint32_t group, collides_with;
    std::int32_t x, y, z, grid;  ///< its cell
    std::uint32_t bucket;
    std::uint32_t next, previous;  ///< slots of the same bucket
  };
  /// Calls visit(slot, entry) once for each bound that may overlap a ball, for at most `room`, which it lowers by those
  /// looked at; how many more there may be. Any thread, while nothing changes.
  template <class Visit>
  std::size_t visit_near(const Vec3& center_m, double radius_m, std::uint32_t& room, Visit&& visit) const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffffU;
  static constexpr int kGrids = 64;

  struct Bucket {
    std::uint32_t first = kNone;  ///< slot of the one that was put in last
    std::uint32_t count = 0;
  };
  struct Row {
    std::int32_t x, y, z;
    int grid;
  };
  void enlarge(std::size_t count, parallel::Executor& executor);
  void link(std::uint32_t slot);
  void unlink(std::uint32_t slot);
  template <class SlotOf, class Change>
  void in_shards(parallel::Executor& executor, std::size_t count, SlotOf&& slot_of, Change&& change);
  [[nodiscard]] static double cell_size_m(int grid) { return std::ldexp(1.0, grid - kUnitGrid); }
  // Of the cells from row.x to last_x in a row.
  template <class Visit>
  std::size_t visit_row(Row row, std::int32_t last_x, std::uint32_t& room, Visit&& visit) const;
  template <class Visit>
  std::size_t visit_all(int grid, std::uint32_t& room, Visit&& visit) const;

  parallel::UnsetVector<Entry> entries_;  // one a slot
  parallel::UnsetVector<Bucket> buckets_;
  parallel::UnsetVector<std::uint32_t> in_block_;  // one a block of buckets: how many are in it
  std::array<std::size_t, kGrids> in_grid_{};
  std::size_t size_ = 0;
  std::uint64_t version_ = 0;
  parallel::UnsetVector<std::uint32_t> by_shard_;  // scratch: slots, shard by shard of their buckets
  std::vector<std::size_t> counts_;                // scratch
  std::uint64_t block_mask_ = 0;
};

template <class Visit>
std::size_t RestingGrid::visit_near(const Vec3& center_m, double radius_m, std::uint32_t& room, Visit&& visit) const {
  std::size_t left = 0;
  for (int grid = 0; size_ > 0 && grid < kGrids; ++grid) {
    if (in_grid_[static_cast<std::size_t>(grid)] == 0) continue;
    const double cell_m = cell_size_m(grid);
    const double cells_per_m = 1.0 / cell_m;
    // The cells that hold the centre of any ball that may overlap. Rounding must lose none of them.
    constexpr double kRounding = 1e-15;
    const Vec3 around = Vec3::Constant((1.0 + kRounding) * (radius_m + 0.5 * cell_m)) + kRounding * center_m.cwiseAbs();
    std::int32_t low[3];
    std::int32_t high[3];
    double cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = cell_of(center_m[axis] - around[axis], cells_per_m);
      high[axis] = cell_of(center_m[axis] + around[axis], cells_per_m);
      cells *= static_cast<double>(high[axis]) - low[axis] + 1;
    }
    if (cells > static_cast<double>(entries_.size())) {
      left += visit_all(grid, room, visit);
      continue;
    }
    for (std::int32_t z = low[2]; z <= high[2]; ++z) {
      for (std::int32_t y = low[1]; y <= high[1]; ++y) left += visit_row({low[0], y, z, grid}, high[0], room, visit);
    }
  }
  return left;
}

template <class Visit>
std::size_t RestingGrid::visit_row(Row row, std::int32_t last_x, std::uint32_t& room, Visit&& visit) const {
  std::size_t left = 0;
  while (row.x <= last_x) {
    const std::int32_t end = std::min(last_x, row.x | (kBlockRow - 1));
    const std::uint64_t first = bucket_of(row.x, row.y, row.z, row.grid, block_mask_);
    if (in_block_[first / kBlockCells] == 0) {
      row.x = end + 1;
      continue;
    }
    for (std::uint64_t b = first; row.x <= end; ++b, ++row.x) {
      const Bucket& bucket = buckets_[b];
      left += bucket.count - std::min(bucket.count, room);
      for (std::uint32_t slot = bucket.first; slot != kNone && room > 0; slot = entries_[slot].next, --room) {
        const Entry& entry = entries_[slot];
        // Blocks may share a place: the cell itself decides.
        if (entry.x == row.x && entry.y == row.y && entry.z == row.z && entry.grid == row.grid) visit(slot, entry);
      }
    }
  }
  return left;
}

// For a ball that is far larger than those of the grid.
template <class Visit>
std::size_t RestingGrid::visit_all(int grid, std::uint32_t& room, Visit&& visit) const {
  std::size_t left = 0;
  for (std::uint32_t slot = 0; slot < entries_.size(); ++slot) {
    const Entry& entry = entries_[slot];
    if (entry.bucket == kNone || entry.grid != grid) continue;
    if (room == 0) {
      ++left;
      continue;
    }
    --room;
    visit(slot, entry);
  }
  return left;
}

}  // namespace poise::collision
