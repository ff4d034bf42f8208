// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>

#include "math/functions.h"
#include "poise/scheduler/cues.h"

namespace poise::scheduler {
namespace {

using namespace cues;

constexpr std::array kCues{&kFrustum,    &kSize,     &kEccentricity, &kClosing,    &kWaiting,
                           &kImportance, &kHost,     &kOcclusion,    &kGap,        &kDelay,
                           &kOnset,      &kCrowding, &kAttention,    &kHysteresis, &kTouch};

// Products of this and of any gain are finite.
constexpr double kMostWeight = 1e200;

}  // namespace

std::span<const Cue* const> cue_list() { return kCues; }

double raised(double base, double exponent) {
  if (exponent == 0.0) return 1.0;
  // pow costs as much as the rest of the score.
  const double power = exponent == 1.0 ? base : exponent == 2.0 ? base * base : math::pow(base, exponent);
  return std::min(power, kMostFactor);
}

double cue_weight(const Policy& policy, const PairCues& cues) {
  double weight = 1;
  for (const Cue* cue : kCues) {
    const double exponent = policy.*cue->weight;
    if (exponent == 0.0 || cue->factor == nullptr) continue;
    weight = std::min(weight * raised(cue->factor(policy, cues), exponent), kMostWeight);
  }
  return weight;
}

}  // namespace poise::scheduler
