// SPDX-License-Identifier: MIT
#include "poise/scheduler/cues.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>

namespace poise::scheduler {
namespace {

constexpr std::array<float, 4> kErrors = {0.4F, 0.2F, 0.05F, 0.04F};
const FrameFacts kFrame{0, 1, 3, 10};

PairChain chain_at(std::uint32_t level) { return {7, level, kErrors, 4}; }

// A policy with one cue alone.
Policy only(double Policy::*weight, double exponent = 1) {
  Policy policy;
  for (const PolicyField& field : policy_weights()) policy.*field.value = 0;
  policy.*weight = exponent;
  return policy;
}

TEST(CueList, HasEveryWeightInItsOrderWithUnitAndSource) {
  const auto weights = policy_weights();
  ASSERT_EQ(cue_list().size(), weights.size());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const Cue& cue = *cue_list()[i];
    EXPECT_EQ(cue.name, weights[i].name);
    EXPECT_EQ(cue.weight, weights[i].value);
    EXPECT_FALSE(cue.unit.empty()) << cue.name;
    EXPECT_FALSE(cue.source.empty()) << cue.name;
  }
}

TEST(CueList, WeighsByDefaultWhatHasEarnedIt) {
  const Policy policy;
  const std::set<std::string_view> on = {"frustum", "size",       "eccentricity", "closing",
                                         "waiting", "importance", "host",         "touch"};
  for (const Cue* cue : cue_list()) EXPECT_EQ(policy.*cue->weight, on.contains(cue->name) ? 1.0 : 0.0) << cue->name;
  EXPECT_EQ(policy.learning, 0.0);
  EXPECT_EQ(policy.seen_threshold_rad, 0.0);
  EXPECT_EQ(policy.time_price_rad, 0.0);
}

TEST(Cues, AHiddenPairIsRatedLowerAndNeverZero) {
  const Policy policy = only(&Policy::occlusion);
  PairCues cues;
  cues.hidden = true;
  EXPECT_DOUBLE_EQ(cue_weight(policy, cues), policy.hidden_visibility);
  EXPECT_GT(cue_weight(only(&Policy::occlusion, 10), cues), 0.0);
  EXPECT_EQ(cue_weight(policy, PairCues{}), 1.0);
}

TEST(Cues, AGapOrADelayOfItsScaleDoublesTheWeight) {
  PairCues cues;
  cues.gap_rad = static_cast<float>(Policy{}.gap_scale_rad);
  EXPECT_NEAR(cue_weight(only(&Policy::gap), cues), 2.0, 1e-6);
  cues.delay_s = static_cast<float>(Policy{}.delay_scale_s);
  EXPECT_NEAR(cue_weight(only(&Policy::delay), cues), 2.0, 1e-6);
}

TEST(Cues, TheOnsetOfAContactCountsDoubleAndFades) {
  const Policy policy = only(&Policy::onset);
  PairCues cues;
  EXPECT_EQ(cue_weight(policy, cues), 2.0);
  cues.age_s = static_cast<float>(policy.onset_scale_s);
  EXPECT_NEAR(cue_weight(policy, cues), 1.5, 1e-6);
  cues.age_s = 1e6F;
  EXPECT_NEAR(cue_weight(policy, cues), 1.0, 1e-6);
}

TEST(Cues, ACrowdHalvesTheWeightWhereItIsAsLargeAsItsScale) {
  const Policy policy = only(&Policy::crowding);
  PairCues cues;
  EXPECT_EQ(cue_weight(policy, cues), 1.0);
  cues.crowd = 8;
  EXPECT_EQ(cue_weight(policy, cues), 0.5);
}

TEST(Cues, WhatSurelyDoesNotTouchWeighsNothingAndWhatSurelyDoesMost) {
  const Policy policy = only(&Policy::touch);
  const auto factor = [&](float separation) {
    PairCues cues;
    cues.separation = separation;
    return cue_weight(policy, cues);
  };
  EXPECT_EQ(factor(0), 1.0);
  EXPECT_NEAR(factor(1), std::sqrt(1 - std::sqrt(0.5)), 1e-12);
  EXPECT_NEAR(factor(-1), std::sqrt(1 + std::sqrt(0.5)), 1e-12);
  EXPECT_NEAR(factor(1e6F) / (std::sqrt(0.5) * 1e-6), 1, 1e-6) << "falls as 1 / separation";
  EXPECT_NEAR(factor(-1e6F), std::sqrt(2), 1e-9);
  EXPECT_EQ(factor(std::numeric_limits<float>::quiet_NaN()), 1.0);
}

TEST(Cues, AttentionIsAFactor) {
  PairCues cues;
  cues.attended = true;
  EXPECT_EQ(cue_weight(only(&Policy::attention), cues), Policy{}.attention_factor);
  EXPECT_EQ(cue_weight(only(&Policy::attention), PairCues{}), 1.0);
}

TEST(Cues, ThatAreOffChangeNothingWhateverWasMeasured) {
  PairCues cues;
  cues.hidden = cues.attended = true;
  cues.gap_rad = cues.delay_s = 3;
  cues.age_s = 0.2F;
  cues.crowd = 500;
  PairChain chain = chain_at(0);
  chain.last_level = 2;
  EXPECT_EQ(score(Policy{}, kFrame, chain, cues, 0), score(Policy{}, kFrame, chain_at(0), PairCues{}, 0));
}

TEST(Gain, IsWorthMoreUpToTheLevelOfTheFrameBefore) {
  Policy policy;
  policy.hysteresis = 1;
  PairChain chain = chain_at(0);
  const double anew = best_gain_per_work(policy, chain, 1);
  chain.last_level = 1;
  EXPECT_GT(best_gain_per_work(policy, chain, 1), anew);
  chain.level = 1;
  EXPECT_EQ(best_gain_per_work(policy, chain, 1), best_gain_per_work(Policy{}, chain_at(1), 1)) << "it is reached";
}

TEST(Gain, GrowsWithTheFramesForWhichItHolds) {
  constexpr std::array<float, 4> kLifetimes = {0, 3, 3, 3};
  PairChain chain = chain_at(0);
  const double once = best_gain_per_work(Policy{}, chain, 1);
  chain.lifetime_frames = kLifetimes;
  EXPECT_DOUBLE_EQ(best_gain_per_work(Policy{}, chain, 1), 3 * once);
}

TEST(Gain, OfTimeIsThatOfAContactThatNeedNotBeAnswered) {
  constexpr std::array<float, 2> kTwo = {0.3F, 0.3F};
  constexpr std::array<float, 2> kEnded = {0, 0.25F};
  Policy policy;
  policy.time_price_rad = 2;
  policy.answer_units = 10;
  PairChain chain{1, 0, kTwo, 6};
  chain.ended = kEnded;
  EXPECT_DOUBLE_EQ(best_gain_per_work(policy, chain, 1), 2 * 0.25 * 10 / (policy.job_overhead_units + 6));
  chain.ended = {};
  EXPECT_DOUBLE_EQ(best_gain_per_work(policy, chain, 1), 2 * 0.5 * 10 / (policy.job_overhead_units + 6));
}

TEST(Gain, OfLevelsThatEndNothingMoreIsNoTime) {
  constexpr std::array<float, 3> kErrorsLeft = {0.3F, 0.3F, 0.3F};
  constexpr std::array<float, 3> kEnded = {0, 0.5F, 0.75F};
  Policy policy;
  policy.time_price_rad = 1;
  policy.answer_units = 8;
  PairChain chain{1, 1, kErrorsLeft, 4};
  chain.begun = true;
  chain.ended = kEnded;
  EXPECT_DOUBLE_EQ(best_gain_per_work(policy, chain, 1), 0.5 * 8 / 4.0) << "half of those that were left";
}

TEST(Threshold, WhatIsBelowItIsNotSeenAndIsLeftOut) {
  Policy policy;
  policy.seen_threshold_rad = 0.01;
  PairCues cues;
  cues.angle_radpm = 0.05;
  const double seen = score(policy, kFrame, chain_at(0), cues, 0);
  EXPECT_GT(seen, 0) << "0.4 m are 0.02 rad";
  EXPECT_FALSE(left_out(policy, seen));
  const double unseen = score(policy, kFrame, chain_at(2), cues, 0);
  EXPECT_EQ(unseen, 0) << "0.05 m are 0.0025 rad";
  EXPECT_TRUE(left_out(policy, unseen));
  EXPECT_FALSE(left_out(Policy{}, 0.0)) << "no threshold: a score of 0 is the last";
}

TEST(Threshold, RisesWithEccentricity) {
  Policy policy;
  policy.seen_threshold_rad = 0.03;
  PairCues cues;
  cues.angle_radpm = 0.1;
  EXPECT_TRUE(error_is_seen(policy, chain_at(0), cues));
  cues.eccentricity_rad = policy.eccentricity_e2_rad;
  EXPECT_FALSE(error_is_seen(policy, chain_at(0), cues));
}

TEST(Threshold, OfZeroChangesNoScore) {
  PairCues cues;
  cues.angle_radpm = 1e-9;
  EXPECT_GT(score(Policy{}, kFrame, chain_at(2), cues, 0), 0);
}

}  // namespace
}  // namespace poise::scheduler
