// SPDX-License-Identifier: MIT
// The gain of refining a pair, in one place; docs/cues.md.
#include <cmath>

#include "poise/scheduler/cues.h"

namespace poise::scheduler {
namespace {

// Of a level from 0, or `none` where nothing is learned of it.
double at_level(std::span<const float> of_level, std::size_t level, double none) {
  return level < of_level.size() ? bounded(static_cast<double>(of_level[level]), kMostFactor) : none;
}

// Probability that a level finds a pair separated which the completed one did not.
double chance_of_end(const Policy& policy, const PairChain& chain, std::size_t level) {
  if (level >= chain.ended.size()) return policy.chance_of_ending;
  const double before = std::min(at_level(chain.ended, chain.level, 0), 1.0);
  const double after = std::clamp(at_level(chain.ended, level, 0), before, 1.0);
  return before < 1.0 ? (after - before) / (1.0 - before) : 0.0;
}

}  // namespace

double best_gain_per_work(const Policy& policy, const PairChain& chain, double angle_radpm) {
  double best = 0;
  double work = chain.begun ? 0 : policy.job_overhead_units;
  double front = static_cast<double>(chain.front_entries);
  const double removed_rad = policy.chance_of_ending * angle_radpm;
  for (std::size_t level = chain.level + std::size_t{1}; level < chain.error_m.size(); ++level) {
    work += std::max(front, 1.0);
    front *= policy.front_growth;
    const double fall_m = static_cast<double>(chain.error_m[chain.level]) - static_cast<double>(chain.error_m[level]);
    double gain = removed_rad * std::max(0.0, fall_m);
    if (level <= chain.last_level) gain *= raised(policy.hysteresis_factor, policy.hysteresis);
    if (policy.time_price_rad > 0)
      gain += policy.time_price_rad * chance_of_end(policy, chain, level) * policy.answer_units;
    best = std::max(best, gain * at_level(chain.lifetime_frames, level, 1.0) / work);
  }
  return best;
}

bool error_is_seen(const Policy& policy, const PairChain& chain, const PairCues& cues) {
  if (chain.level >= chain.error_m.size()) return false;
  const double error_rad =
      std::abs(static_cast<double>(chain.error_m[chain.level])) * bounded(cues.angle_radpm, kMostFactor);
  const double eccentricity = bounded(cues.eccentricity_rad, kMostFactor) / policy.eccentricity_e2_rad;
  return error_rad >= policy.seen_threshold_rad * (1.0 + eccentricity);
}

}  // namespace poise::scheduler
