// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/broad_phase/grid_blocks.h"
#include "parallel/shared_counters.h"

/// What the searches of the broad phase share: cells, the test of two balls and the list of what was found.
namespace poise::collision {

inline bool meet(std::uint32_t group_a, std::uint32_t with_a, std::uint32_t group_b, std::uint32_t with_b) {
  return (group_a & with_b) != 0 && (group_b & with_a) != 0;
}

/// Calls use(slot) for the planes that a ball may touch, if it is one that moves.
template <class Ball, class Use>
void for_planes(const Ball& self, std::span<const PlaneBound> planes, Use&& use) {
  if (!self.dynamic) return;
  for (const PlaneBound& plane : planes) {
    if (plane.normal.dot(self.center_m) - plane.height_m >= self.radius_m) continue;
    if (meet(self.group, self.collides_with, plane.group, plane.collides_with)) use(plane.slot);
  }
}

/// Squared distance of two centres less that at which the balls would touch.
template <class A, class B>
double beyond_m2(const A& self, const B& other) {
  const double reach = self.radius_m + other.radius_m;
  return (other.center_m - self.center_m).squaredNorm() - reach * reach;
}

/// Do balls overlap that are so far beyond touching? What is no number counts as near.
inline bool overlap(double beyond) { return !(beyond >= 0); }

/// Collects the pairs of one worker and writes them out in batches.
struct BroadPhase::Collector {
  static constexpr std::size_t kBatch = 512;
  std::span<CandidatePair> out;
  parallel::Tickets& tickets;
  std::size_t count = 0;
  std::size_t discarded = 0, looked_at = 0;
  std::array<CandidatePair, kBatch> batch;

  Collector(std::span<CandidatePair> into, parallel::Tickets& places) : out(into), tickets(places) {}
  void add(std::uint32_t a, std::uint32_t b) {
    batch[count++] = {std::min(a, b), std::max(a, b)};
    if (count == kBatch) flush();
  }
  // The same for `n` partners of one.
  template <class SlotOf>
  void add_all(std::uint32_t own, std::size_t n, SlotOf&& slot_of) {
    for (std::size_t i = 0; i < n;) {
      const std::size_t past = std::min(n, i + kBatch - count);
      for (; i < past; ++i) {
        const std::uint32_t slot = slot_of(i);
        batch[count++] = {std::min(own, slot), std::max(own, slot)};
      }
      if (count == kBatch) flush();
    }
  }
  void flush() {
    const std::size_t begin = tickets.take(count);
    // Beyond the end pairs are only counted: the caller enlarges the buffer and repeats the search.
    const std::size_t room = out.size() - std::min(begin, out.size());
    std::copy_n(batch.begin(), std::min(count, room),
                out.begin() + static_cast<std::ptrdiff_t>(std::min(begin, out.size())));
    count = 0;
  }
};

inline std::uint64_t BroadPhase::bucket(const Cell& cell) const {
  return bucket_of(cell.x, cell.y, cell.z, cell.grid, block_mask_);
}

}  // namespace poise::collision
