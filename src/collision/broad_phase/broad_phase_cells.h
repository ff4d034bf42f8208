// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/broad_phase/grid_blocks.h"
#include "parallel/shared_counters.h"

/// What the two searches of the broad phase share: cells and the list of what was found.
namespace poise::collision {

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

inline std::uint64_t BroadPhase::bucket(const Cell& cell) const {
  return bucket_of(cell.x, cell.y, cell.z, cell.grid, block_mask_);
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
