// SPDX-License-Identifier: MIT
#include "world/learned_gains.h"

#include <algorithm>

namespace poise::simulation {
namespace {

// Counts above this are halved with their sums, so that what was long ago counts less. Chosen.
constexpr float kMemory = 4096;

void halve(float& count, float& sum) {
  if (count < kMemory) return;
  count *= 0.5F;
  sum *= 0.5F;
}

void add(const GainObservation& seen, ShapePairGains& gains) {
  for (std::size_t level = 1; level <= seen.level; ++level) {
    LevelGain& gain = gains.level[level];
    halve(gain.refined, gain.ended);
    gain.refined += 1;
    if (level == seen.level) gain.ended += static_cast<float>(seen.apart);
  }
  if (seen.anew != 0) {
    LevelGain& gain = gains.level[seen.level];
    halve(gain.anew, gain.change_m);
    gain.anew += 1;
    gain.change_m += seen.change_m;
  }
  if (seen.life == GainObservation::Life::Unknown) return;
  LevelGain& gain = gains.level[seen.life_level];
  halve(gain.hazard, gain.expired);
  gain.hazard += seen.hazard;
  if (seen.life == GainObservation::Life::Expired) gain.expired += 1;
}

}  // namespace

std::size_t LearnedGains::bucket_of(std::uint32_t shape_low, std::uint32_t shape_high) const {
  const std::uint64_t key = (std::uint64_t{shape_low} << 32U | shape_high) * 0x9e3779b97f4a7c15ULL;
  std::size_t bucket = static_cast<std::size_t>(key >> 52U);
  static_assert(kBuckets == std::size_t{1} << 12U && kBuckets > 2 * kMostShapePairs, "never full, so a search ends");
  while (buckets_[bucket] != 0) {
    const ShapePairGains& entry = entries_[buckets_[bucket]];
    if (entry.shape_low == shape_low && entry.shape_high == shape_high) break;
    bucket = (bucket + 1) % kBuckets;
  }
  return bucket;
}

const ShapePairGains* LearnedGains::find(std::uint32_t shape_low, std::uint32_t shape_high) const {
  if (entries_.empty()) return nullptr;
  const std::uint16_t entry = buckets_[bucket_of(shape_low, shape_high)];
  if (entry != 0) return &entries_[entry];
  return entries_.size() > kMostShapePairs ? &entries_.front() : nullptr;
}

ShapePairGains& LearnedGains::entry_of(std::uint32_t shape_low, std::uint32_t shape_high) {
  const std::size_t bucket = bucket_of(shape_low, shape_high);
  if (buckets_[bucket] == 0) {
    if (entries_.size() > kMostShapePairs) return entries_.front();
    buckets_[bucket] = static_cast<std::uint16_t>(entries_.size());
    entries_.push_back({shape_low, shape_high, {}});
  }
  return entries_[buckets_[bucket]];
}

void LearnedGains::learn() {
  if (observed_.empty()) return;
  if (entries_.empty()) {
    entries_.reserve(kMostShapePairs + 1);
    entries_.push_back({0xffffffffU, 0xffffffffU, {}});
    buckets_.assign(kBuckets, 0);
  }
  for (const GainObservation& seen : observed_) add(seen, entry_of(seen.shape_low, seen.shape_high));
  observed_.clear();
}

void LearnedGains::clear() {
  entries_.clear();
  buckets_.clear();
  observed_.clear();
}

}  // namespace poise::simulation
