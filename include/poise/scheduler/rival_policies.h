// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>

#include "poise/scheduler/policy.h"

/// The rules of the policies that rival the perceptual one, one small file each in scheduler/policies; `score` calls
/// them. Results are finite and >= 0, and at most 1 but for size_score. Any thread.
namespace poise::scheduler {

/// What a rule is asked about.
struct Turn {
  const Policy& policy;
  const FrameFacts& frame;
  const PairChain& chain;
  const PairCues& cues;
  std::uint32_t queue_index = 0;
};

/// Laps of a queue in which each pair has a level a lap, and the one that a pair is in.
inline double laps_of(const Turn& turn) { return static_cast<double>(std::max(turn.frame.deepest_level, 1U)); }
inline double lap_of(const Turn& turn) {
  return static_cast<double>(std::min(turn.chain.level, std::max(turn.frame.deepest_level, 1U)));
}
/// A pair's place in the queue, in [0, 1).
inline double place_of(const Turn& turn) {
  return std::min(1.0, static_cast<double>(turn.queue_index) / static_cast<double>(std::max(turn.frame.pairs, 1U)));
}

double fifo_score(const Turn& turn);
double random_score(const Turn& turn);
double round_robin_score(const Turn& turn);
double size_score(const Turn& turn);
double deepest_score(const Turn& turn);
double equal_levels_score(const Turn& turn);

}  // namespace poise::scheduler
