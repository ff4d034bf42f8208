// SPDX-License-Identifier: MIT
#include "world/contact_cache.h"

#include <algorithm>

#include "parallel/ranges.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kSlotGrain = 1024;

}  // namespace

std::size_t SlotAllocator::points_before_pairs(const PointCache& cache, std::size_t workers) {
  std::size_t left_over = 0;
  for (const std::uint8_t points : PointCache::kPointsOfSize) left_over += kBlock * points;
  return cache.points.size() + workers * left_over;
}

void SlotAllocator::begin(PointCache& cache, std::size_t pairs, std::size_t most_pairs, parallel::Executor& executor) {
  const auto workers = static_cast<std::size_t>(executor.concurrency());
  if (rooms_.size() < workers) rooms_.resize(workers);
  // No size has more slots than there were pairs at once, and those that workers have left over.
  const std::size_t slots = most_pairs + workers * kBlock;
  cache.released.reserve(slots);
  for (std::vector<std::uint32_t>& free : cache.free) free.reserve(slots);
  for (Room& room : rooms_) room.left.reserve(most_pairs);
  for (parallel::Tickets& taken : taken_) taken.reset();
  std::array<std::size_t, PointCache::kSizes> before{};
  parallel::group(
      executor, cache.released.size(), kSlotGrain, PointCache::kSizes, counts_,
      [&](std::size_t i) { return PointCache::size_of(cache.released[i]); },
      [&](std::span<const std::size_t> released) {
        for (std::size_t size = 0; size < PointCache::kSizes; ++size) {
          before[size] = cache.free[size].size();
          cache.free[size].resize(before[size] + released[size]);
        }
      },
      [&](std::size_t i, std::size_t size, std::size_t position) {
        cache.free[size][before[size] + position] = cache.released[i];
      });
  cache.released.clear();

  added_.reset();
  points_before_ = cache.points.size();
  const std::size_t most = most_points(cache, pairs, workers);
  if (most > cache.points.capacity()) {
    // Half as much again for what the pairs of later frames will have.
    const std::size_t room = points_before_pairs(cache, workers) + kPointsOfPair * most_pairs * 3 / 2;
    parallel::reserve(executor, cache.points, room);
    parallel::reserve(executor, cache.forces, room);
  }
  cache.points.resize(most);
  cache.forces.resize(most);
}

std::uint32_t SlotAllocator::take(const PointCache& cache, std::size_t point_count, int worker) {
  const std::size_t size = PointCache::size_for(point_count);
  Room& room = rooms_[static_cast<std::size_t>(worker)];
  if (room.count[size] == 0) refill(cache, size, room);
  return room.slots[size][--room.count[size]];
}

void SlotAllocator::refill(const PointCache& cache, std::size_t size, Room& room) {
  const std::vector<std::uint32_t>& free = cache.free[size];
  const std::size_t first = taken_[size].take(kBlock);
  if (first < free.size()) {
    const std::size_t count = std::min(kBlock, free.size() - first);
    std::copy_n(free.end() - static_cast<std::ptrdiff_t>(first + count), count, room.slots[size].begin());
    room.count[size] = static_cast<std::uint32_t>(count);
    return;
  }
  const std::size_t points = PointCache::kPointsOfSize[size];
  const std::size_t begin = points_before_ + added_.take(kBlock * points);
  // The lowest is handed out first.
  for (std::size_t k = 0; k < kBlock; ++k)
    room.slots[size][k] = PointCache::slot_at(begin + (kBlock - 1 - k) * points, size);
  room.count[size] = kBlock;
}

void SlotAllocator::end(PointCache& cache) {
  for (std::size_t size = 0; size < PointCache::kSizes; ++size) {
    std::vector<std::uint32_t>& free = cache.free[size];
    free.resize(free.size() - std::min(free.size(), taken_[size].next()));
  }
  for (Room& room : rooms_) {
    for (std::size_t size = 0; size < PointCache::kSizes; ++size) {
      const auto& slots = room.slots[size];
      cache.released.insert(cache.released.end(), slots.begin(), slots.begin() + room.count[size]);
      room.count[size] = 0;
    }
    cache.released.insert(cache.released.end(), room.left.begin(), room.left.end());
    room.left.clear();
  }
  cache.points.resize(points_before_ + added_.next());
  cache.forces.resize(cache.points.size());
}

}  // namespace poise::simulation
