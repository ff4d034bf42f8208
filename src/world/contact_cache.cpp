// SPDX-License-Identifier: MIT
#include "world/contact_cache.h"

#include "parallel/ranges.h"

namespace poise::simulation {

void PointCache::reserve(std::size_t slots, parallel::Executor& executor) {
  parallel::reserve(executor, points, slots * kPointsOfPair);
  parallel::reserve(executor, forces, slots * kForcesOfPair);
  free.reserve(slots);
}

void PointCache::reserve_slots(std::size_t count, parallel::Executor& executor) {
  if (count <= free.size()) return;
  const std::size_t first = points.size() / kPointsOfPair;
  const std::size_t more = count - free.size();
  parallel::resize(executor, points, (first + more) * kPointsOfPair);
  parallel::resize(executor, forces, (first + more) * kForcesOfPair);
  free.reserve(first + more);
  // The lowest of the new ones is taken first, after those that were released.
  free.insert(free.begin(), more, 0);
  for (std::size_t k = 0; k < more; ++k) free[k] = static_cast<std::uint32_t>(first + more - 1 - k);
}

}  // namespace poise::simulation
