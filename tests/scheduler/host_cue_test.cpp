// SPDX-License-Identifier: MIT
#include "poise/scheduler/host_cue.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "poise/scheduler/policy.h"

namespace poise::scheduler {
namespace {

constexpr std::array<float, 3> kErrors = {0.4F, 0.2F, 0.05F};
constexpr FrameFacts kFrame{3, 1, 2, 10};

double given_number(const PairView& /*view*/, void* context) noexcept { return *static_cast<const double*>(context); }

// The host has marked one ball with 7; the cue favours it.
double ball_first(const PairView& view, void* /*context*/) noexcept {
  return view.user_data.a == 7 || view.user_data.b == 7 ? 100.0 : 1.0;
}

double deepest_first(const FrameFacts& /*frame*/, const PairChain& chain, const PairCues& cues,
                     void* /*context*/) noexcept {
  return (1.0 + chain.level) * static_cast<double>(chain.user_data.a + 1) * static_cast<double>(cues.host);
}

double given_score(const FrameFacts& /*frame*/, const PairChain& /*chain*/, const PairCues& /*cues*/,
                   void* context) noexcept {
  return *static_cast<const double*>(context);
}

TEST(HostCue, IsAFactorOfTheScoreAndReadsUserData) {
  Policy policy;
  policy.cue = {ball_first, nullptr};
  const auto scored = [&](std::uint64_t user_data) {
    PairView view;
    view.user_data.b = user_data;
    PairCues cues;
    cues.host = host_factor(policy.cue, view).factor;
    return score(policy, kFrame, {1, 0, kErrors, 8}, cues, 0);
  };
  EXPECT_DOUBLE_EQ(scored(7), 100 * scored(8));
  const double with = scored(7);
  policy.host = 0.5;
  EXPECT_DOUBLE_EQ(scored(7), with / 10) << "raised to its weight";
  policy.host = 0;
  EXPECT_EQ(scored(7), scored(8)) << "switched off";
}

TEST(HostCue, ThatIsNotThereChangesNothingToTheBit) {
  EXPECT_EQ(host_factor({}, {}).factor, 1.0F);
  PairCues cues;
  cues.closing_mps = 1.7;
  cues.eccentricity_rad = 0.3;
  cues.frames_waited = 3;
  Policy policy;
  const double with = score(policy, kFrame, {1, 0, kErrors, 8}, cues, 0);
  policy.host = 0;
  EXPECT_EQ(std::bit_cast<std::uint64_t>(with),
            std::bit_cast<std::uint64_t>(score(policy, kFrame, {1, 0, kErrors, 8}, cues, 0)));
}

TEST(HostCue, WhatItMayNotGiveIsBoundedAndReported) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto asked = [](double value) { return host_factor({given_number, &value}, {}); };
  EXPECT_EQ(asked(2.5).factor, 2.5F);
  EXPECT_FALSE(asked(2.5).refused);
  EXPECT_FALSE(asked(0).refused);
  EXPECT_FALSE(asked(kMostHostFactor).refused);
  EXPECT_EQ(asked(-1).factor, 0.0F);
  EXPECT_TRUE(asked(-1).refused);
  EXPECT_EQ(asked(kInfinity).factor, static_cast<float>(kMostHostFactor));
  EXPECT_TRUE(asked(kInfinity).refused);
  EXPECT_EQ(asked(std::nan("")).factor, 1.0F);
  EXPECT_TRUE(asked(std::nan("")).refused);
}

RC_GTEST_PROP(HostCue, AnyNumberBecomesAFactorInItsRange, ()) {
  double value = std::bit_cast<double>(*rc::gen::arbitrary<std::uint64_t>());
  const HostFactor got = host_factor({given_number, &value}, {});
  RC_ASSERT(got.factor >= 0.0F && got.factor <= static_cast<float>(kMostHostFactor));
  RC_ASSERT(got.refused == !(value >= 0 && value <= kMostHostFactor));
}

TEST(HostPolicy, DecidesTheOrderFromChainCuesAndUserData) {
  Policy policy{PolicyKind::Custom};
  EXPECT_FALSE(valid(policy)) << "no function";
  EXPECT_EQ(text_of(*first_problem(policy)), "custom.function = 0, must be set where kind is custom");
  EXPECT_EQ(score(policy, kFrame, {1, 0, kErrors, 8}, {}, 0), 0) << "and no harm done";
  policy.custom = {deepest_first, nullptr};
  EXPECT_TRUE(valid(policy));
  const auto scored = [&](std::uint32_t level, std::uint64_t mark) {
    return score(policy, kFrame, {1, level, kErrors, 8, {mark, 0}}, {}, 0);
  };
  EXPECT_EQ(scored(1, 0), 2.0);
  EXPECT_EQ(scored(1, 4), 10.0);
  EXPECT_GT(band_of(policy, scored(1, 0)), band_of(policy, scored(0, 0)));
  PairCues favoured;
  favoured.host = 3;
  EXPECT_EQ(score(policy, kFrame, {1, 1, kErrors, 8}, favoured, 0), 6.0);
}

TEST(HostPolicy, ScoresOfAnyUnitAreToldApart) {
  const Policy policy{PolicyKind::Custom};
  for (double x = 1e-9; x < 1e9; x *= 2) EXPECT_GT(band_of(policy, 2 * x), band_of(policy, x)) << x;
}

RC_GTEST_PROP(HostPolicy, NoNumberThatItGivesIsLeftUnranked, ()) {
  double value = std::bit_cast<double>(*rc::gen::arbitrary<std::uint64_t>());
  if (*rc::gen::inRange(0, 4) == 0) value = *rc::gen::element(std::nan(""), HUGE_VAL, -HUGE_VAL, -0.0);
  Policy policy{PolicyKind::Custom};
  policy.custom = {given_score, &value};
  const double got = score(policy, kFrame, {1, 0, kErrors, 8}, {}, 0);
  RC_ASSERT(std::isfinite(got) && got >= 0 && got <= kMostScore);
  RC_ASSERT(band_of(policy, got) < kBands);
  if (value >= 0 && value <= kMostScore) RC_ASSERT(got == value);
}

TEST(PairCues, FitIntoACacheLine) { EXPECT_LE(sizeof(PairCues), 64U); }

}  // namespace
}  // namespace poise::scheduler
