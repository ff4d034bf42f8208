// SPDX-License-Identifier: MIT
#include "poise/scheduler/policy.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace poise::scheduler {
namespace {

constexpr double kMostExponent = 10;
constexpr std::array kWeights{
    PolicyField{"frustum", &Policy::frustum, 0, kMostExponent},
    PolicyField{"size", &Policy::size, 0, kMostExponent},
    PolicyField{"eccentricity", &Policy::eccentricity, 0, kMostExponent},
    PolicyField{"closing", &Policy::closing, 0, kMostExponent},
    PolicyField{"waiting", &Policy::waiting, 0, kMostExponent},
    PolicyField{"importance", &Policy::importance, 0, kMostExponent},
    PolicyField{"host", &Policy::host, 0, kMostExponent},
};
// The ranges include all useful values with some orders of magnitude to spare, and exclude division by zero.
constexpr std::array kParameters{
    PolicyField{"outside_frustum", &Policy::outside_frustum, 1e-6, 1},
    PolicyField{"eccentricity_e2_rad", &Policy::eccentricity_e2_rad, 1e-4, 10},
    PolicyField{"closing_scale_mps", &Policy::closing_scale_mps, 1e-6, 1e6},
    PolicyField{"plain_angle_radpm", &Policy::plain_angle_radpm, 1e-6, 1e3},
    PolicyField{"chance_of_ending", &Policy::chance_of_ending, 1e-3, 1},
    PolicyField{"front_growth", &Policy::front_growth, 1, 64},
    PolicyField{"job_overhead_units", &Policy::job_overhead_units, 1e-3, 1e6},
};
constexpr std::array kCounts{
    PolicyCount{"quantum_units", &Policy::quantum_units, 1, 1U << 20U},
    PolicyCount{"round_pairs", &Policy::round_pairs, 1, 1U << 20U},
};

// Clamps to [0, most]; NaN becomes 0, which depends on the order of the arguments.
double bounded(double x, double most) { return std::min(std::max(0.0, x), most); }

// For base >= 0. Common weights are 0 and 1, and pow costs as much as the rest of the score.
double raised(double base, double exponent) {
  if (exponent == 0.0) return 1.0;
  return std::min(exponent == 1.0 ? base : std::pow(base, exponent), kMostFactor);
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
  double weight = raised(bounded(cues.visibility, 1.0), policy.frustum);
  weight *= raised(1.0 / (1.0 + bounded(cues.eccentricity_rad, kMostFactor) / policy.eccentricity_e2_rad),
                   policy.eccentricity);
  weight *= raised(1.0 + bounded(cues.closing_mps, kMostFactor) / policy.closing_scale_mps, policy.closing);
  weight *= raised(1.0 + static_cast<double>(cues.frames_waited), policy.waiting);
  weight *= raised(bounded(cues.importance, kMostFactor), policy.importance);
  weight *= raised(bounded(static_cast<double>(cues.host), kMostHostFactor), policy.host);
  return weight;
}

double best_gain_per_work(const Policy& policy, const PairChain& chain, double angle_radpm) {
  double best = 0;
  double work = chain.begun ? 0 : policy.job_overhead_units;
  double front = static_cast<double>(chain.front_entries);
  for (std::size_t level = chain.level + std::size_t{1}; level < chain.error_m.size(); ++level) {
    work += std::max(front, 1.0);
    front *= policy.front_growth;
    const double fall_m = static_cast<double>(chain.error_m[chain.level]) - static_cast<double>(chain.error_m[level]);
    best = std::max(best, fall_m / work);
  }
  return policy.chance_of_ending * angle_radpm * best;
}

double score(const Policy& policy, const FrameFacts& frame, const PairChain& chain, const PairCues& cues,
             std::uint32_t queue_index) {
  switch (policy.kind) {
    case PolicyKind::Perceptual: {
      const double angle = bounded(cues.angle_radpm, kMostFactor) / policy.plain_angle_radpm;
      const double gain = best_gain_per_work(policy, chain, policy.plain_angle_radpm * raised(angle, policy.size));
      return bounded(cue_weight(policy, cues) * gain, kMostScore);
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
    case PolicyKind::Custom:
      if (policy.custom.function == nullptr) return 0;
      return bounded(policy.custom.function(frame, chain, cues, policy.custom.context), kMostScore);
  }
  return 0;
}

std::uint32_t band_of(const Policy& policy, double score) {
  // From 2^-56 to 2^8 radians per expansion.
  constexpr double kLowestOctave = -56.0;
  if (policy.kind == PolicyKind::Perceptual) return octave_band(score, kLowestOctave);
  return policy.kind == PolicyKind::Custom ? octave_band(score) : linear_band(score);
}

std::span<const PolicyField> policy_weights() { return kWeights; }
std::span<const PolicyField> policy_parameters() { return kParameters; }
std::span<const PolicyCount> policy_counts() { return kCounts; }

std::optional<Problem> first_problem(const Policy& policy) {
  for (const std::span<const PolicyField> fields : {policy_weights(), policy_parameters()}) {
    for (const PolicyField& field : fields) {
      const double value = policy.*field.value;
      if (!(value >= field.least && value <= field.most))
        return Problem{field.name, value, field.least, field.most, {}};
    }
  }
  for (const PolicyCount& count : kCounts) {
    const std::uint32_t value = policy.*count.value;
    if (value < count.least || value > count.most) {
      return Problem{count.name,
                     static_cast<double>(value),
                     static_cast<double>(count.least),
                     static_cast<double>(count.most),
                     {}};
    }
  }
  if (policy.kind > PolicyKind::Custom) {
    return Problem{"kind", static_cast<double>(policy.kind), 0, static_cast<double>(PolicyKind::Custom), {}};
  }
  if (policy.kind == PolicyKind::Custom && policy.custom.function == nullptr) {
    return Problem{"custom.function", 0, 0, 0, "must be set where kind is custom"};
  }
  return std::nullopt;
}

}  // namespace poise::scheduler
