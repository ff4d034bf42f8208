// SPDX-License-Identifier: MIT
#include "collision/broad_phase/resting_grid.h"

#include <bit>
#include <numeric>

#include "parallel/ranges.h"
#include "poise_assert.h"

namespace poise::collision {
namespace {

constexpr std::size_t kGrain = 256;
// Buckets are changed in parallel by shards, of about so many bounds each.
constexpr std::size_t kFewestShards = 16, kMostShards = 512, kOfShard = 4096;
// Bounds that are counted one after another before the executor may stop.
constexpr std::size_t kCountGrain = 16384;

}  // namespace

// Calls change(slot) for each that is in; those of one bucket follow each other in the order of the list.
template <class SlotOf, class Change>
void RestingGrid::in_shards(parallel::Executor& executor, std::size_t count, SlotOf&& slot_of, Change&& change) {
  if (count < kGrain) {
    for (std::size_t i = 0; i < count; ++i) {
      if (holds(slot_of(i))) change(slot_of(i));
    }
    return;
  }
  const std::size_t shards = std::clamp(std::bit_ceil(count / kOfShard), kFewestShards, kMostShards);
  // After the last shard what is not in.
  std::array<std::size_t, kMostShards + 2> begins{};
  parallel::group(
      executor, count, kGrain, shards + 1, counts_,
      [&](std::size_t i) {
        const std::uint32_t slot = slot_of(i);
        return holds(slot) ? entries_[slot].bucket / kBlockCells % shards : shards;
      },
      [&](std::span<const std::size_t> sizes) {
        std::partial_sum(sizes.begin(), sizes.end(), begins.begin() + 1);
        by_shard_.resize(count);
      },
      [&](std::size_t i, std::size_t shard, std::size_t position) {
        by_shard_[begins[shard] + position] = slot_of(i);
      });
  parallel::parallel_for(executor, shards, 1, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begins[begin]; k < begins[end]; ++k) change(by_shard_[k]);
  });
}

void RestingGrid::link(std::uint32_t slot) {
  Entry& entry = entries_[slot];
  Bucket& bucket = buckets_[entry.bucket];
  entry.previous = kNone;
  entry.next = bucket.first;
  if (entry.next != kNone) entries_[entry.next].previous = slot;
  bucket.first = slot;
  ++bucket.count;
  ++in_block_[entry.bucket / kBlockCells];
}

void RestingGrid::unlink(std::uint32_t slot) {
  Entry& entry = entries_[slot];
  if (entry.next != kNone) entries_[entry.next].previous = entry.previous;
  Bucket& bucket = buckets_[entry.bucket];
  (entry.previous != kNone ? entries_[entry.previous].next : bucket.first) = entry.next;
  --bucket.count;
  --in_block_[entry.bucket / kBlockCells];
}

// Buckets for so many: four a bound, as in the grid of what moves.
void RestingGrid::enlarge(std::size_t count, parallel::Executor& executor) {
  const std::size_t buckets = std::bit_ceil(std::max<std::size_t>(4 * count, kBlockCells));
  if (buckets <= buckets_.size()) return;
  block_mask_ = buckets / kBlockCells - 1;
  buckets_.clear();
  in_block_.clear();
  parallel::resize(executor, buckets_, buckets);
  parallel::resize(executor, in_block_, buckets / kBlockCells);
  const auto held = [&](std::size_t slot) { return entries_[slot].bucket != kNone; };
  parallel::parallel_for(executor, entries_.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t slot = begin; slot < end; ++slot) {
      Entry& entry = entries_[slot];
      if (held(slot))
        entry.bucket = static_cast<std::uint32_t>(bucket_of(entry.x, entry.y, entry.z, entry.grid, block_mask_));
    }
  });
  in_shards(
      executor, entries_.size(), [&](std::size_t i) { return static_cast<std::uint32_t>(i); },
      [&](std::uint32_t slot) { link(slot); });
}

void RestingGrid::change(std::span<const std::uint32_t> taken, std::span<const MotionBound> put,
                         parallel::Executor& executor) {
  if (taken.empty() && put.empty()) return;
  ++version_;
  in_shards(
      executor, taken.size(), [&](std::size_t i) { return taken[i]; }, [&](std::uint32_t slot) { unlink(slot); });
  parallel::serial_for(executor, taken.size(), kCountGrain, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t slot : taken.subspan(begin, end - begin)) {
      POISE_ASSERT(holds(slot));
      --in_grid_[static_cast<std::size_t>(entries_[slot].grid)];
      entries_[slot].bucket = kNone;
    }
  });
  size_ = size_ - taken.size() + put.size();
  std::uint32_t slots = 0;
  parallel::serial_for(executor, put.size(), kCountGrain, [&](std::size_t begin, std::size_t end) {
    for (const MotionBound& bound : put.subspan(begin, end - begin)) slots = std::max(slots, bound.slot + 1);
  });
  if (slots > entries_.size()) {
    Entry none{};
    none.bucket = kNone;
    parallel::resize(executor, entries_, slots, none);
  }
  enlarge(std::max(size_, entries_.capacity() / 2), executor);
  parallel::parallel_for(executor, put.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      const MotionBound& bound = put[i];
      Entry& entry = entries_[bound.slot];
      entry.center_m = bound.center_m;
      entry.radius_m = bound.radius_m;
      entry.group = bound.group;
      entry.collides_with = bound.collides_with;
      entry.grid = grid_of(bound.radius_m);
      const double cells_per_m = 1.0 / cell_size_m(entry.grid);
      entry.x = cell_of(bound.center_m.x(), cells_per_m);
      entry.y = cell_of(bound.center_m.y(), cells_per_m);
      entry.z = cell_of(bound.center_m.z(), cells_per_m);
      entry.bucket = static_cast<std::uint32_t>(bucket_of(entry.x, entry.y, entry.z, entry.grid, block_mask_));
    }
  });
  parallel::serial_for(executor, put.size(), kCountGrain, [&](std::size_t begin, std::size_t end) {
    for (const MotionBound& bound : put.subspan(begin, end - begin))
      ++in_grid_[static_cast<std::size_t>(entries_[bound.slot].grid)];
  });
  in_shards(
      executor, put.size(), [&](std::size_t i) { return put[i].slot; }, [&](std::uint32_t slot) { link(slot); });
}

void RestingGrid::clear() {
  entries_.clear();
  std::fill(buckets_.begin(), buckets_.end(), Bucket{});
  std::fill(in_block_.begin(), in_block_.end(), 0U);
  in_grid_ = {};
  size_ = 0;
  ++version_;
}

}  // namespace poise::collision
