// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <span>
#include <string_view>

#include "poise/scheduler/policy.h"

/// The cues, one file each (scheduler/cues): what is measured of a pair, and the factor that it gives to its score.
namespace poise::scheduler {

/// A cue. Its factor is raised to its weight; a weight of 0 switches it off, and then it is neither measured nor
/// computed.
struct Cue {
  std::string_view name;  ///< also that of its weight in scenes
  double Policy::*weight;
  std::string_view unit;    ///< of what is measured
  std::string_view source;  ///< of the factor; `chosen` where there is none
  /// The factor of a pair, finite and >= 0 for a valid policy. Null: it acts within the gain of a level.
  double (*factor)(const Policy& policy, const PairCues& cues);
};

namespace cues {
extern const Cue kFrustum, kSize, kEccentricity, kClosing, kWaiting, kImportance, kHost, kOcclusion, kGap, kDelay,
    kOnset, kCrowding, kAttention, kHysteresis, kTouch;
}  // namespace cues

/// All cues, in the order of policy_weights().
std::span<const Cue* const> cue_list();

/// Clamps to [0, most]; NaN becomes 0, which depends on the order of the arguments.
inline double bounded(double x, double most) { return std::min(std::max(0.0, x), most); }

/// base^exponent for base >= 0, at most kMostFactor; 1 for an exponent of 0. Common exponents are 0 and 1.
double raised(double base, double exponent);

}  // namespace poise::scheduler
