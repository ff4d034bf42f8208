// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "parallel/shared_counters.h"

/// What the two searches of the broad phase share: cells and the list of what was found.
namespace poise::collision {

inline constexpr double kFarthestCell = 1e9;

inline std::int32_t cell_of(double x_m, double cells_per_meter) {
  return static_cast<std::int32_t>(std::clamp(std::floor(x_m * cells_per_meter), -kFarthestCell, kFarthestCell));
}

inline bool meet(std::uint32_t group_a, std::uint32_t with_a, std::uint32_t group_b, std::uint32_t with_b) {
  return (group_a & with_b) != 0 && (group_b & with_a) != 0;
}

/// Collects the pairs of one worker and writes them out in batches.
struct BroadPhase::Collector {
  static constexpr std::size_t kBatch = 512;
  std::span<CandidatePair> out;
  parallel::Tickets& tickets;
  std::vector<Partner>& partners;  // scratch: of one search
  std::size_t count = 0;
  std::size_t discarded = 0, looked_at = 0;
  CandidatePair batch[kBatch] = {};

  void add(std::uint32_t a, std::uint32_t b) {
    batch[count++] = {std::min(a, b), std::max(a, b)};
    if (count == kBatch) flush();
  }
  // Adds the partners of a search, if they are too many the nearest of them.
  void keep_nearest(std::uint32_t own, std::uint32_t max_partners) {
    if (partners.size() > max_partners) {
      discarded += partners.size() - max_partners;
      const auto end = partners.begin() + max_partners;
      std::nth_element(partners.begin(), end, partners.end(), [](const Partner& x, const Partner& y) {
        return x.beyond_m2 != y.beyond_m2 ? x.beyond_m2 < y.beyond_m2 : x.slot < y.slot;
      });
      partners.erase(end, partners.end());
    }
    for (const Partner& partner : partners) add(own, partner.slot);
  }
  void flush() {
    const std::size_t begin = tickets.take(count);
    // Beyond the end pairs are only counted: the caller enlarges the buffer and repeats the search.
    const std::size_t room = out.size() - std::min(begin, out.size());
    std::copy_n(batch, std::min(count, room), out.begin() + static_cast<std::ptrdiff_t>(std::min(begin, out.size())));
    count = 0;
  }
};

// Buckets of neighbouring cells lie side by side, in blocks of 16 x 4 x 4 that are placed by a hash: a search of
// neighbours reads what lies together, and no arrangement of bodies puts many cells into one bucket.
inline constexpr std::int32_t kBlockRow = 16;
inline constexpr std::uint64_t kBlockCells = std::uint64_t{kBlockRow} * 4 * 4;

inline std::uint64_t BroadPhase::bucket(const Cell& cell) const {
  const auto block = [](std::int32_t at, int bits) { return static_cast<std::uint64_t>(at >> bits); };
  const std::uint64_t hash = block(cell.x, 4) * 0x9e3779b97f4a7c15U + block(cell.y, 2) * 0xc2b2ae3d27d4eb4fU +
                             block(cell.z, 2) * 0x165667b19e3779f9U +
                             static_cast<std::uint64_t>(cell.grid) * 0x27d4eb2f165667c5U;
  const auto inside = static_cast<std::uint64_t>((cell.z & 3) << 6 | (cell.y & 3) << 4 | (cell.x & 15));
  return ((hash >> 32U) & block_mask_) * kBlockCells + inside;
}

template <class Visit>
std::size_t BroadPhase::visit_row(const Cell& first, std::int32_t count, std::uint32_t& room, Visit&& visit) const {
  std::size_t left = 0;
  Cell from = first;
  const std::int32_t end = first.x + count;
  while (from.x < end) {
    const std::int32_t next = std::min(end, (from.x | (kBlockRow - 1)) + 1);
    const std::uint64_t begin = bucket(from);
    const std::uint64_t behind = begin + static_cast<std::uint64_t>(next - from.x);
    const std::uint32_t end_entry = bucket_begin_[behind];
    std::uint32_t e = bucket_begin_[begin];
    for (; e < end_entry && room > 0; ++e, --room) {
      const Cell& cell = entries_[e].cell;
      // Blocks may share a place: the cell itself decides.
      if (cell.grid != first.grid || cell.y != first.y || cell.z != first.z) continue;
      if (cell.x < from.x || cell.x >= next) continue;
      visit(e);
    }
    left += end_entry - e;
    from.x = next;
  }
  return left;
}

}  // namespace poise::collision
