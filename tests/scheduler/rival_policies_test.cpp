// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <cmath>

#include "poise/scheduler/policy.h"

namespace poise::scheduler {
namespace {

constexpr std::array<float, 4> kErrors = {0.4F, 0.2F, 0.05F, 0.04F};
constexpr FrameFacts kFrame{0, 1, 3, 100};

PairChain chain_at(std::uint32_t level) { return {7, level, kErrors, 1}; }

double score_of(PolicyKind kind, std::uint32_t level, std::uint32_t place, const PairCues& cues = {},
                const FrameFacts& frame = kFrame) {
  return score(Policy{kind}, frame, chain_at(level), cues, place);
}

TEST(RoundRobin, ServesTheGroupNearTheGazeBeforeTheFrustumAndThatBeforeTheRest) {
  PairCues near;
  PairCues seen;
  seen.eccentricity_rad = 0.3;
  PairCues outside;
  outside.visibility = Policy{}.outside_frustum;
  EXPECT_GT(score_of(PolicyKind::RoundRobin, 2, 99, near), score_of(PolicyKind::RoundRobin, 0, 0, seen));
  EXPECT_GT(score_of(PolicyKind::RoundRobin, 2, 99, seen), score_of(PolicyKind::RoundRobin, 0, 0, outside));
}

TEST(RoundRobin, GivesEachPairOfAGroupALevelBeforeAnyGetsTwo) {
  EXPECT_GT(score_of(PolicyKind::RoundRobin, 0, 99), score_of(PolicyKind::RoundRobin, 1, 0));
  EXPECT_GT(score_of(PolicyKind::RoundRobin, 0, 0), score_of(PolicyKind::RoundRobin, 0, 1));
}

TEST(RoundRobin, BeginsWithAnotherPairInTheNextFrame) {
  const FrameFacts next{1, 1, 3, 100};
  EXPECT_GT(score_of(PolicyKind::RoundRobin, 0, 40, {}, next), score_of(PolicyKind::RoundRobin, 0, 0, {}, next));
}

TEST(SizePolicy, ServesTheLargestVisibleErrorWhateverItCosts) {
  PairCues large;
  large.angle_radpm = 2 * kDefaultPlainAngleRadpm;
  EXPECT_GT(score_of(PolicyKind::Size, 0, 0, large), score_of(PolicyKind::Size, 0, 0));
  EXPECT_GT(score_of(PolicyKind::Size, 0, 0), score_of(PolicyKind::Size, 1, 0)) << "less is left to see";
  const Policy policy{PolicyKind::Size};
  EXPECT_EQ(score(policy, kFrame, {7, 0, kErrors, 1}, {}, 0), score(policy, kFrame, {7, 0, kErrors, 900}, {}, 0));
  PairCues broken;
  broken.angle_radpm = std::nan("");
  EXPECT_EQ(score_of(PolicyKind::Size, 0, 0, broken), 0);
  EXPECT_EQ(score_of(PolicyKind::Size, 9, 0), 0) << "no level is left";
}

TEST(DeepestPolicy, RefinesAPairToItsEndBeforeTheNext) {
  EXPECT_GT(score_of(PolicyKind::Deepest, 1, 99), score_of(PolicyKind::Deepest, 0, 0));
  EXPECT_GT(score_of(PolicyKind::Deepest, 1, 0), score_of(PolicyKind::Deepest, 1, 1));
}

TEST(EqualLevels, BringsAllPairsToALevelBeforeAnyGoesDeeperAndThoseFirstThatHaveWaited) {
  PairCues waited;
  waited.frames_waited = 4;
  EXPECT_GT(score_of(PolicyKind::EqualLevels, 0, 99, waited), score_of(PolicyKind::EqualLevels, 0, 0));
  EXPECT_GT(score_of(PolicyKind::EqualLevels, 0, 99), score_of(PolicyKind::EqualLevels, 1, 0, waited));
}

RC_GTEST_PROP(RivalPolicies, ScoresAreFiniteAndTheirBandsMonotone, ()) {
  const Policy policy{
      *rc::gen::element(PolicyKind::RoundRobin, PolicyKind::Size, PolicyKind::Deepest, PolicyKind::EqualLevels)};
  const auto drawn = [&] {
    PairCues cues;
    cues.angle_radpm = std::ldexp(1.0, *rc::gen::inRange(-60, 60));
    cues.eccentricity_rad = *rc::gen::inRange(0, 300) * 0.01;
    cues.frames_waited = *rc::gen::arbitrary<std::uint32_t>();
    const FrameFacts frame{*rc::gen::arbitrary<std::uint64_t>(), 1, *rc::gen::inRange(0U, 7U), 50};
    return score(policy, frame, chain_at(*rc::gen::inRange(0U, 6U)), cues, *rc::gen::inRange(0U, 80U));
  };
  const double x = drawn();
  const double y = drawn();
  RC_ASSERT(std::isfinite(x) && x >= 0 && x <= kMostScore);
  RC_ASSERT(band_of(policy, x) < kBands);
  RC_ASSERT((x <= y) == (band_of(policy, x) <= band_of(policy, y)) || band_of(policy, x) == band_of(policy, y));
}

}  // namespace
}  // namespace poise::scheduler
