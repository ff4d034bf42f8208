// SPDX-License-Identifier: MIT
#include "poise/scheduler/policy.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "math/functions.h"
#include "poise/scheduler/cues.h"
#include "poise/scheduler/rival_policies.h"

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
    PolicyField{"occlusion", &Policy::occlusion, 0, kMostExponent},
    PolicyField{"gap", &Policy::gap, 0, kMostExponent},
    PolicyField{"delay", &Policy::delay, 0, kMostExponent},
    PolicyField{"onset", &Policy::onset, 0, kMostExponent},
    PolicyField{"crowding", &Policy::crowding, 0, kMostExponent},
    PolicyField{"attention", &Policy::attention, 0, kMostExponent},
    PolicyField{"hysteresis", &Policy::hysteresis, 0, kMostExponent},
    PolicyField{"touch", &Policy::touch, 0, kMostExponent},
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
    PolicyField{"hidden_visibility", &Policy::hidden_visibility, 1e-6, 1},
    PolicyField{"gap_scale_rad", &Policy::gap_scale_rad, 1e-6, 10},
    PolicyField{"delay_scale_s", &Policy::delay_scale_s, 1e-4, 1e3},
    PolicyField{"onset_scale_s", &Policy::onset_scale_s, 1e-4, 1e3},
    PolicyField{"crowding_scale", &Policy::crowding_scale, 1e-3, 1e6},
    PolicyField{"attention_factor", &Policy::attention_factor, 1, 1e4},
    PolicyField{"hysteresis_factor", &Policy::hysteresis_factor, 1, 1e4},
    PolicyField{"seen_threshold_rad", &Policy::seen_threshold_rad, 0, 10},
    PolicyField{"learning", &Policy::learning, 0, 1},
    PolicyField{"time_price_rad", &Policy::time_price_rad, 0, 1e3},
    PolicyField{"answer_units", &Policy::answer_units, 0, 1e6},
};
constexpr std::array kCounts{
    PolicyCount{"quantum_units", &Policy::quantum_units, 1, 1U << 20U},
    PolicyCount{"round_pairs", &Policy::round_pairs, 1, 1U << 20U},
};

}  // namespace

double score(const Policy& policy, const FrameFacts& frame, const PairChain& chain, const PairCues& cues,
             std::uint32_t queue_index) {
  const Turn turn{policy, frame, chain, cues, queue_index};
  switch (policy.kind) {
    case PolicyKind::Perceptual: {
      const double angle = bounded(cues.angle_radpm, kMostFactor) / policy.plain_angle_radpm;
      const bool seen = policy.seen_threshold_rad == 0 || error_is_seen(policy, chain, cues);
      const double gain =
          best_gain_per_work(policy, chain, seen ? policy.plain_angle_radpm * raised(angle, policy.size) : 0);
      return bounded(cue_weight(policy, cues) * gain, kMostScore);
    }
    case PolicyKind::Fifo:
      return fifo_score(turn);
    case PolicyKind::Random:
      return random_score(turn);
    case PolicyKind::RoundRobin:
      return round_robin_score(turn);
    case PolicyKind::Size:
      return size_score(turn);
    case PolicyKind::Deepest:
      return deepest_score(turn);
    case PolicyKind::EqualLevels:
      return equal_levels_score(turn);
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
  const bool of_any_size = policy.kind == PolicyKind::Custom || policy.kind == PolicyKind::Size;
  return of_any_size ? octave_band(score) : linear_band(score);
}

std::uint32_t waited_bands(const Policy& policy, std::uint32_t frames) {
  if (policy.kind != PolicyKind::Perceptual || frames == 0) return 0;
  PairCues cues;
  cues.frames_waited = frames;
  constexpr double kBandsOfAnOctave = 4;
  const double octaves = policy.waiting * math::log2(cues::kWaiting.factor(policy, cues));
  return static_cast<std::uint32_t>(std::clamp(std::round(kBandsOfAnOctave * octaves), 0.0, kBands - 1.0));
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
  if (policy.kind > kLastPolicyKind) {
    return Problem{"kind", static_cast<double>(policy.kind), 0, static_cast<double>(kLastPolicyKind), {}};
  }
  if (policy.kind == PolicyKind::Custom && policy.custom.function == nullptr) {
    return Problem{"custom.function", 0, 0, 0, "must be set where kind is custom"};
  }
  return std::nullopt;
}

}  // namespace poise::scheduler
