// SPDX-License-Identifier: MIT
// The accepted range of each policy setting; every accepted policy must give scores that can be ranked.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "poise/scheduler/policy.h"

namespace poise::scheduler {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

std::vector<PolicyField> all_fields() {
  std::vector<PolicyField> fields(policy_weights().begin(), policy_weights().end());
  fields.insert(fields.end(), policy_parameters().begin(), policy_parameters().end());
  return fields;
}

TEST(PolicyRange, TheDefaultsAreWhatTheyWereBeforeTheyHadNames) {
  const Policy policy;
  EXPECT_TRUE(valid(policy));
  EXPECT_EQ(policy.outside_frustum, 0.05);
  EXPECT_EQ(policy.eccentricity_e2_rad, 2.5 * 3.14159265358979323846 / 180.0);
  EXPECT_EQ(policy.closing_scale_mps, 1.0);
  EXPECT_EQ(policy.plain_angle_radpm, 0.1);
  EXPECT_EQ(policy.chance_of_ending, 0.5);
  EXPECT_EQ(policy.front_growth, 2.0);
  EXPECT_EQ(policy.job_overhead_units, 4.0);
  EXPECT_EQ(policy.quantum_units, 512U);
  EXPECT_EQ(policy.round_pairs, 512U);
}

TEST(PolicyRange, EveryFieldIsRefusedBeyondItsRangeAndNamed) {
  for (const PolicyField& field : all_fields()) {
    for (const double bad : {std::nextafter(field.least, -kInfinity), std::nextafter(field.most, kInfinity), kInfinity,
                             -kInfinity, kNan}) {
      Policy policy;
      policy.*field.value = bad;
      const auto problem = first_problem(policy);
      ASSERT_TRUE(problem.has_value()) << field.name << " = " << bad;
      EXPECT_EQ(problem->field, field.name);
      EXPECT_FALSE(valid(policy));
    }
    for (const double good : {field.least, field.most}) {
      Policy policy;
      policy.*field.value = good;
      EXPECT_TRUE(valid(policy)) << field.name << " = " << good;
    }
  }
  for (const PolicyCount& count : policy_counts()) {
    Policy policy;
    policy.*count.value = count.least - 1;
    ASSERT_TRUE(first_problem(policy).has_value());
    EXPECT_EQ(first_problem(policy)->field, count.name);
    policy.*count.value = count.most + 1;
    EXPECT_FALSE(valid(policy));
  }
}

TEST(PolicyRange, NoFieldIsForgottenInTheTables) {
  // A kind, weights, parameters, counts, and host functions; a new field makes the policy larger than the listed ones.
  std::vector<PolicyField> fields = all_fields();
  EXPECT_EQ(sizeof(Policy), (fields.size() + 1) * sizeof(double) + policy_counts().size() * sizeof(std::uint32_t) +
                                sizeof(HostCue) + sizeof(HostPolicy));
  const bool distinct = [&] {
    std::ranges::sort(fields, {}, &PolicyField::name);
    return std::ranges::adjacent_find(fields, {}, &PolicyField::name) == fields.end();
  }();
  EXPECT_TRUE(distinct);
}

TEST(PolicyRange, AProblemSaysFieldValueAndRule) {
  Policy policy;
  policy.closing_scale_mps = -1;
  const auto problem = first_problem(policy);
  ASSERT_TRUE(problem.has_value());
  EXPECT_EQ(text_of(*problem), "closing_scale_mps = -1, must be in [1e-06, 1e+06]");
  EXPECT_EQ(text_of({"names", 2, 0, 0, "must differ"}), "names = 2, must differ");
}

TEST(PolicyRange, ParametersMoveTheScoreTheRightWay) {
  const std::array<float, 3> errors = {0.4F, 0.2F, 0.1F};
  PairCues cues;
  cues.closing_mps = 3;
  cues.eccentricity_rad = 0.3;
  const auto scored = [&](double Policy::*parameter, double value) {
    Policy policy;
    policy.*parameter = value;
    return score(policy, {0, 1, 3, 10}, {7, 0, errors, 10}, cues, 0);
  };
  EXPECT_GT(scored(&Policy::closing_scale_mps, 0.5), scored(&Policy::closing_scale_mps, 2));
  EXPECT_GT(scored(&Policy::eccentricity_e2_rad, 0.2), scored(&Policy::eccentricity_e2_rad, 0.1));
  EXPECT_GT(scored(&Policy::chance_of_ending, 0.9), scored(&Policy::chance_of_ending, 0.1));
  EXPECT_GT(scored(&Policy::job_overhead_units, 1), scored(&Policy::job_overhead_units, 100));
  // Two levels with equal fronts are cheaper than with a second front twice as large.
  const std::array<float, 3> late = {0.4F, 0.4F, 0.0F};
  Policy growing, steady;
  steady.front_growth = 1;
  EXPECT_GT(best_gain_per_work(steady, {1, 0, late, 10}, 1), best_gain_per_work(growing, {1, 0, late, 10}, 1));
  EXPECT_DOUBLE_EQ(best_gain_per_work(steady, {1, 0, late, 10}, 1), 0.5 * static_cast<double>(0.4F) / 24.0);
}

// Any bits are a double: all kinds of NaN, infinities and numbers near zero are included; often an end of a range.
double any_number() {
  const auto bits = *rc::gen::arbitrary<std::uint64_t>();
  const double drawn = std::bit_cast<double>(bits);
  return *rc::gen::element(drawn, 0.0, -0.0, 1.0, -1.0, kInfinity, -kInfinity, kNan, std::numeric_limits<double>::max(),
                           std::numeric_limits<double>::lowest(), std::numeric_limits<double>::denorm_min(), 3.0);
}

Policy any_accepted_policy() {
  Policy policy{*rc::gen::element(PolicyKind::Perceptual, PolicyKind::Fifo, PolicyKind::Random)};
  for (const PolicyField& field : all_fields()) {
    const double share = *rc::gen::inRange(0, 101) * 0.01;
    // Half of them at an end of the range, the others spread over its orders of magnitude.
    const double least = std::max(field.least, 1e-9);
    const double within = std::clamp(least * std::pow(field.most / least, share), field.least, field.most);
    policy.*field.value = *rc::gen::element(field.least, field.most, within, within);
  }
  return policy;
}

RC_GTEST_PROP(PolicyRange, NoAcceptedPolicyAndNoCueGivesANumberThatCannotBeRanked, ()) {
  const Policy policy = any_accepted_policy();
  RC_ASSERT(valid(policy));
  for (int i = 0; i < 20; ++i) {
    PairCues cues;
    cues.visibility = any_number();
    cues.angle_radpm = any_number();
    cues.eccentricity_rad = any_number();
    cues.closing_mps = any_number();
    cues.importance = static_cast<float>(std::clamp(any_number(), -3e38, 3e38));
    cues.host = static_cast<float>(std::clamp(any_number(), -3e38, 3e38));
    cues.frames_waited = *rc::gen::element(0U, 1U, 1000U, 0xffffffffU);
    for (float* measured : {&cues.gap_rad, &cues.delay_s, &cues.age_s, &cues.separation})
      *measured = static_cast<float>(std::clamp(any_number(), -3e38, 3e38));
    cues.crowd = *rc::gen::arbitrary<std::uint16_t>();
    cues.hidden = *rc::gen::arbitrary<bool>();
    cues.attended = *rc::gen::arbitrary<bool>();
    std::array<float, 6> errors{};
    for (float& error_m : errors) error_m = static_cast<float>(std::clamp(any_number(), -3e38, 3e38));
    std::array<float, 6> lifetimes{}, ended{};
    for (float& number : lifetimes) number = static_cast<float>(std::clamp(any_number(), -3e38, 3e38));
    for (float& number : ended) number = static_cast<float>(std::clamp(any_number(), -3e38, 3e38));
    PairChain chain{*rc::gen::arbitrary<std::uint64_t>(), *rc::gen::inRange(0U, 8U), errors,
                    *rc::gen::element<std::uint64_t>(0, 1, 1000, ~std::uint64_t{0})};
    chain.last_level = *rc::gen::inRange(0U, 8U);
    if (*rc::gen::arbitrary<bool>()) chain.lifetime_frames = lifetimes;
    if (*rc::gen::arbitrary<bool>()) chain.ended = ended;
    const FrameFacts facts{*rc::gen::arbitrary<std::uint64_t>(), *rc::gen::arbitrary<std::uint64_t>(),
                           *rc::gen::inRange(0U, 20U), *rc::gen::inRange(0U, 1000U)};
    const double weight = cue_weight(policy, cues);
    RC_ASSERT(std::isfinite(weight) && weight >= 0);
    const double scored = score(policy, facts, chain, cues, *rc::gen::inRange(0U, 2000U));
    RC_ASSERT(std::isfinite(scored) && scored >= 0 && scored <= kMostScore);
    RC_ASSERT(band_of(policy, scored) < kBands);
  }
}

RC_GTEST_PROP(PolicyRange, EveryNumberHasABand, ()) {
  const double x = any_number();
  RC_ASSERT(linear_band(x) < kBands);
  RC_ASSERT(octave_band(x) < kBands);
  RC_ASSERT(band_of(Policy{}, x) < kBands);
}

RC_GTEST_PROP(PolicyRange, AnyFieldThatIsNotANumberInItsRangeIsRefused, ()) {
  const auto fields = all_fields();
  const PolicyField field = fields[*rc::gen::inRange<std::size_t>(0, fields.size())];
  const double value = any_number();
  Policy policy;
  policy.*field.value = value;
  RC_ASSERT(valid(policy) == (value >= field.least && value <= field.most));
}

}  // namespace
}  // namespace poise::scheduler
