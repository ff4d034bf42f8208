// SPDX-License-Identifier: MIT
#include "frame/refine/learned_chain.h"

#include <algorithm>

namespace poise::simulation {
namespace {

double mean_of(double prior, float sum, float count) {
  return (kPriorPairs * prior + static_cast<double>(sum)) / (kPriorPairs + static_cast<double>(count));
}

}  // namespace

double hazard_by_motion(const ActivePair& pair) {
  const double moves_m = pair.margin_m - pair.skin_m;
  const double slack_m = pair.reach_m - pair.margin_m;
  return moves_m < slack_m ? std::max(1 / kMostLifetime, moves_m / slack_m) : 1.0;
}

void expect_as_learned(const ShapePairGains* gains, const scheduler::Policy& policy, double hazard, std::size_t deepest,
                       ExpectedLevels& expected) {
  static constexpr LevelGain kNothing{};
  const double chance = policy.chance_of_ending;
  const auto share_of = [&](double learned, double prior) { return prior + policy.learning * (learned - prior); };
  // What refinement from level 0 to each level removes. The error that is left at the deepest level stays.
  std::array<double, kPolygonBin + 1> removed_m{};
  double together = 1;  // probability that the pair is not found separated
  expected.ended[0] = 0;
  for (std::size_t level = 1; level <= deepest; ++level) {
    const LevelGain& gain = gains != nullptr ? gains->level[level] : kNothing;
    const double prior_m =
        chance * (static_cast<double>(expected.error_m[0]) - static_cast<double>(expected.error_m[level]));
    removed_m[level] = share_of(mean_of(prior_m, gain.change_m, gain.anew), prior_m);
    together *= 1 - mean_of(level == 1 ? chance : 0.0, gain.ended, gain.refined);
    expected.ended[level] = static_cast<float>(share_of(1 - together, chance));
    const double expires = std::clamp(
        hazard * (kPriorPairs + static_cast<double>(gain.expired)) / (kPriorPairs + static_cast<double>(gain.hazard)),
        1 / kMostLifetime, 1.0);
    expected.lifetime_frames[level] = static_cast<float>(share_of(1 / expires, 1.0));
  }
  const double left_m = static_cast<double>(expected.error_m[deepest]);
  for (std::size_t level = 0; level < deepest; ++level)
    expected.error_m[level] = static_cast<float>(left_m + (removed_m[deepest] - removed_m[level]) / chance);
}

}  // namespace poise::simulation
