// SPDX-License-Identifier: MIT
#include "poise/scheduler/policy.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cmath>

namespace poise::scheduler {
namespace {

constexpr std::array<float, 4> kErrors = {0.4F, 0.2F, 0.05F, 0.04F};

PairChain chain_at(std::uint32_t level, std::uint64_t front = 1) { return {7, level, kErrors, front}; }

TEST(Policy, GainIsTheFallOfErrorPerUnitOfWork) {
  const std::array<float, 2> two = {0.3F, 0.1F};
  const double fall_m = static_cast<double>(0.3F) - static_cast<double>(0.1F);
  const double expected = 0.5 * 0.5 * fall_m / (4.0 + 10.0);
  EXPECT_DOUBLE_EQ(best_gain_per_work(Policy{}, {1, 0, two, 10}, 0.5), expected);
}

TEST(Policy, AChainIsJudgedByItsBestAverageNotItsNextStep) {
  // The first level gains nothing, the second everything: the pair must not be held back by its first level.
  const std::array<float, 3> late = {0.4F, 0.4F, 0.0F};
  EXPECT_GT(best_gain_per_work(Policy{}, {1, 0, late, 4}, 1.0), 0.0);
}

TEST(Policy, NothingIsGainedBelowTheDeepestLevel) { EXPECT_EQ(best_gain_per_work(Policy{}, chain_at(3), 1.0), 0.0); }

TEST(Policy, ALargerFrontIsWorthLessPerUnit) {
  EXPECT_GT(best_gain_per_work(Policy{}, chain_at(0, 4), 1.0), best_gain_per_work(Policy{}, chain_at(0, 40), 1.0));
}

TEST(Policy, EachCueMovesTheScoreTheRightWay) {
  const Policy policy;
  const FrameFacts frame{0, 1, 3, 10};
  const auto score_with = [&](auto change) {
    PairCues cues;
    change(cues);
    return score(policy, frame, chain_at(0), cues, 0);
  };
  const double plain = score_with([](PairCues&) {});
  EXPECT_LT(score_with([](PairCues& c) { c.visibility = Policy{}.outside_frustum; }), plain);
  EXPECT_GT(score_with([](PairCues& c) { c.angle_radpm = 10 * kDefaultPlainAngleRadpm; }), plain);
  EXPECT_LT(score_with([](PairCues& c) { c.eccentricity_rad = 0.5; }), plain);
  EXPECT_GT(score_with([](PairCues& c) { c.closing_mps = 3; }), plain);
  EXPECT_GT(score_with([](PairCues& c) { c.frames_waited = 5; }), plain);
  EXPECT_GT(score_with([](PairCues& c) { c.importance = 2; }), plain);
}

TEST(Policy, AnEccentricityOfE2HalvesTheWeight) {
  PairCues cues;
  cues.eccentricity_rad = Policy{}.eccentricity_e2_rad;
  EXPECT_DOUBLE_EQ(cue_weight(Policy{}, cues), 0.5);
}

TEST(Policy, AWeightOfZeroSwitchesItsCueOff) {
  Policy off;
  for (const PolicyField& weight : policy_weights()) off.*weight.value = 0;
  PairCues cues;
  cues.visibility = Policy{}.outside_frustum;
  cues.angle_radpm = 3;
  cues.eccentricity_rad = 1;
  cues.closing_mps = 9;
  cues.frames_waited = 100;
  cues.importance = 50;
  EXPECT_EQ(score(off, {}, chain_at(0), cues, 0), score(off, {}, chain_at(0), PairCues{}, 0));
}

TEST(Policy, WaitingOvertakesEveryOtherCueInTheEnd) {
  const Policy policy;
  PairCues favoured;
  favoured.closing_mps = 20;
  PairCues hidden;
  hidden.visibility = Policy{}.outside_frustum;
  hidden.frames_waited = 2000;
  EXPECT_GT(cue_weight(policy, hidden), cue_weight(policy, favoured));
}

TEST(Policy, FifoServesInOrderAndSendsARefinedPairToTheBack) {
  const Policy fifo{PolicyKind::Fifo};
  const FrameFacts frame{0, 1, 3, 100};
  const auto at = [&](std::uint32_t level, std::uint32_t place) {
    return score(fifo, frame, chain_at(level), PairCues{}, place);
  };
  EXPECT_GT(at(0, 0), at(0, 1));
  EXPECT_GT(at(0, 99), at(1, 0));
  EXPECT_GT(band_of(fifo, at(0, 0)), band_of(fifo, at(1, 50)));
}

TEST(Policy, RandomDrawsAnewEachFrameAndRepeatsForASeed) {
  const Policy random{PolicyKind::Random};
  const auto draw = [&](std::uint64_t frame, std::uint64_t seed) {
    return score(random, {frame, seed, 3, 10}, chain_at(0), PairCues{}, 0);
  };
  EXPECT_EQ(draw(4, 9), draw(4, 9));
  EXPECT_NE(draw(4, 9), draw(5, 9));
  EXPECT_NE(draw(4, 9), draw(4, 10));
}

RC_GTEST_PROP(Policy, BandsAreMonotoneInTheScore, ()) {
  const Policy policy{*rc::gen::element(PolicyKind::Perceptual, PolicyKind::Fifo, PolicyKind::Random)};
  const double x = std::ldexp(1.0 + *rc::gen::inRange(0, 1000) * 1e-3, *rc::gen::inRange(-80, 20));
  const double y = std::ldexp(1.0 + *rc::gen::inRange(0, 1000) * 1e-3, *rc::gen::inRange(-80, 20));
  RC_ASSERT(band_of(policy, x) < kBands);
  RC_ASSERT((x <= y) == (band_of(policy, x) <= band_of(policy, y)) || band_of(policy, x) == band_of(policy, y));
}

TEST(WaitedBands, AreTheBandsBetweenAPairThatWaitedAndOneThatDidNot) {
  Policy policy;
  EXPECT_EQ(waited_bands(policy, 0), 0U);
  EXPECT_EQ(waited_bands(policy, 1), 4U) << "twice the score: an octave";
  EXPECT_EQ(waited_bands(policy, 15), 16U);
  const double score = 1e-3;
  for (const std::uint32_t frames : {2U, 7U, 100U}) {
    const auto bands = static_cast<double>(band_of(policy, (1.0 + frames) * score) - band_of(policy, score));
    EXPECT_NEAR(waited_bands(policy, frames), bands, 1) << frames;
  }
  policy.waiting = 0;
  EXPECT_EQ(waited_bands(policy, 1000), 0U);
  policy.waiting = 10;
  EXPECT_LT(waited_bands(policy, 0xffffffffU), kBands);
  policy.kind = PolicyKind::Fifo;
  EXPECT_EQ(waited_bands(policy, 1000), 0U) << "others have no such cue";
}

}  // namespace
}  // namespace poise::scheduler
