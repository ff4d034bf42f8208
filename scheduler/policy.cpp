// SPDX-License-Identifier: MIT
#include "poise/scheduler/policy.h"

#include <algorithm>
#include <cmath>

namespace poise::scheduler {
namespace {

// Common weights are 0 and 1, and pow costs as much as the rest of the score.
double raised(double base, double exponent) {
  if (exponent == 1.0) return base;
  if (exponent == 0.0) return 1.0;
  return std::pow(base, exponent);
}

// SplitMix64's finaliser (Steele, Lea and Flood 2014): a bijection that mixes every bit.
std::uint64_t mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27U)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31U);
}

double unit_interval(std::uint64_t bits) { return static_cast<double>(bits >> 11U) * 0x1.0p-53; }

}  // namespace

double cue_weight(const Policy& policy, const PairCues& cues) {
  double weight = raised(cues.visibility, policy.frustum);
  weight *= raised(1.0 / (1.0 + cues.eccentricity_rad / kEccentricityE2Rad), policy.eccentricity);
  weight *= raised(1.0 + cues.closing_mps, policy.closing);
  weight *= raised(1.0 + static_cast<double>(cues.frames_waited), policy.waiting);
  weight *= raised(cues.importance, policy.importance);
  return weight;
}

double best_gain_per_work(const PairChain& chain, double angle_radpm) {
  double best = 0;
  double work = kJobOverheadUnits;
  double front = static_cast<double>(chain.front_entries);
  for (std::size_t level = chain.level + 1U; level < chain.error_m.size(); ++level) {
    work += front;
    front *= kFrontGrowth;
    const double fall_m = static_cast<double>(chain.error_m[chain.level]) - static_cast<double>(chain.error_m[level]);
    best = std::max(best, fall_m / work);
  }
  return kChanceOfEnding * angle_radpm * best;
}

double score(const Policy& policy, const FrameFacts& frame, const PairChain& chain, const PairCues& cues,
             std::uint32_t queue_index) {
  switch (policy.kind) {
    case PolicyKind::Perceptual: {
      const double angle = kPlainAngleRadpm * raised(cues.angle_radpm / kPlainAngleRadpm, policy.size);
      return cue_weight(policy, cues) * best_gain_per_work(chain, angle);
    }
    case PolicyKind::Fifo: {
      // Every level is one lap of the queue, and the first lap comes first.
      const double laps = static_cast<double>(std::max(frame.deepest_level, 1U));
      const double place = static_cast<double>(queue_index) / static_cast<double>(std::max(frame.pairs, 1U));
      const double lap = static_cast<double>(std::min(chain.level, std::max(frame.deepest_level, 1U)));
      return std::max(0.0, (laps - lap - place) / laps);
    }
    case PolicyKind::Random:
      return unit_interval(mixed(chain.pair_id ^ mixed(frame.frame ^ mixed(frame.seed + chain.level))));
  }
  return 0;
}

std::uint32_t band_of(const Policy& policy, double score) {
  constexpr double kTop = kBands - 1;
  if (!(score > 0)) return 0;
  if (policy.kind != PolicyKind::Perceptual) {
    return static_cast<std::uint32_t>(std::clamp(score * kBands, 0.0, kTop));
  }
  // Four bands an octave, from 2^-56 to 2^8 radians per expansion.
  return static_cast<std::uint32_t>(std::clamp(4.0 * (std::log2(score) + 56.0), 0.0, kTop));
}

bool valid(const Policy& policy) {
  const double weights[] = {policy.frustum, policy.size,    policy.eccentricity,
                            policy.closing, policy.waiting, policy.importance};
  return std::all_of(std::begin(weights), std::end(weights),
                     [](double weight) { return std::isfinite(weight) && weight >= 0; });
}

}  // namespace poise::scheduler
