// SPDX-License-Identifier: MIT
#include "poise/scheduler/rival_policies.h"

namespace poise::scheduler {
namespace {

// SplitMix64's finaliser (Steele, Lea and Flood 2014): a bijection that mixes every bit.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}

double unit_interval(std::uint64_t bits) { return static_cast<double>(bits >> 11U) * 0x1.0p-53; }

}  // namespace

double random_score(const Turn& turn) {
  const std::uint64_t drawn = mixed(turn.frame.frame ^ mixed(turn.frame.seed + turn.chain.level));
  return unit_interval(mixed(turn.chain.pair_id ^ drawn));
}

}  // namespace poise::scheduler
