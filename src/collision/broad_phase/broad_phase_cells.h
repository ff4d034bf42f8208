// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

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
  std::size_t count = 0;
  std::size_t discarded = 0;
  CandidatePair batch[kBatch] = {};

  void add(std::uint32_t a, std::uint32_t b) {
    batch[count++] = {std::min(a, b), std::max(a, b)};
    if (count == kBatch) flush();
  }
  void flush() {
    const std::size_t begin = tickets.take(count);
    // Beyond the end pairs are only counted: the caller enlarges the buffer and repeats the search.
    const std::size_t room = out.size() - std::min(begin, out.size());
    std::copy_n(batch, std::min(count, room), out.begin() + static_cast<std::ptrdiff_t>(std::min(begin, out.size())));
    count = 0;
  }
};

/// Calls visit for the entries of `count` cells in a row along x.
template <class Visit>
void BroadPhase::visit_row(const Cell& first, std::int32_t count, Visit&& visit) const {
  const auto visit_buckets = [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint32_t e = bucket_begin_[begin]; e < bucket_begin_[end]; ++e) {
      const Cell& cell = entries_[e].cell;
      // Far cells may share a bucket: the cell itself decides.
      if (cell.grid != first.grid || cell.y != first.y || cell.z != first.z) continue;
      if (cell.x < first.x || cell.x >= first.x + count) continue;
      visit(e);
    }
  };
  const std::uint64_t begin = bucket(first);
  const std::uint64_t end = begin + static_cast<std::uint64_t>(count);
  if (end <= mask_ + 1) {
    visit_buckets(begin, end);
  } else {
    visit_buckets(begin, mask_ + 1);
    visit_buckets(0, end - mask_ - 1);
  }
}

}  // namespace poise::collision
