// SPDX-License-Identifier: MIT
#include "scene/compare/comparison.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "scene/compare/comparison_document.h"

namespace poise::io {
namespace {

ComparedStep step_of(double e_seen_mps) {
  ComparedStep step;
  step.converged = true;
  step.e_mps = 2 * e_seen_mps;
  step.e_rel = 0.5;
  step.e_seen_mps = e_seen_mps;
  step.work_units = 10;
  return step;
}

// Two policies, budgets 0 and 10: their E_seen in each frame is that of the frame times `first`, `second`, and falls to
// half with the budget.
ComparedSteps steps_of(const std::vector<double>& frames, double first, double second,
                       const std::string& name = "random") {
  ComparedSteps steps{{"perceptual", name}, {0, 10}, {}};
  for (const double frame : frames) {
    for (const double policy : {first, second}) {
      for (const double budget : {1.0, 0.5}) steps.steps.push_back(step_of(frame * policy * budget));
    }
  }
  return steps;
}

TEST(Comparison, MeansOverFramesAndTheMeanHeightOfTheCurve) {
  const PolicyComparison result = compare_steps(steps_of({1, 2, 3}, 1, 2), 1);
  ASSERT_EQ(result.rows.size(), 4U);
  EXPECT_EQ(result.frames, 3U);
  EXPECT_EQ(result.rows[0].policy, "perceptual");
  EXPECT_DOUBLE_EQ(result.rows[0].e_seen_mps.mean, 2);
  EXPECT_DOUBLE_EQ(result.rows[0].e_mps.mean, 4);
  EXPECT_DOUBLE_EQ(result.rows[1].e_seen_mps.mean, 1);
  EXPECT_EQ(result.rows[1].budget, 10);
  EXPECT_DOUBLE_EQ(result.rows[2].e_seen_mps.mean, 4);
  EXPECT_DOUBLE_EQ(result.areas[0].e_seen_mps.mean, 1.5);
  EXPECT_DOUBLE_EQ(result.areas[1].e_seen_mps.mean, 3);
  EXPECT_FALSE(result.rows[0].regret_mps) << "no oracle took part";
  EXPECT_FALSE(result.rows[0].gap_mean_px) << "no frame defines it";
}

TEST(Comparison, IntervalsHoldTheMeanAndRepeatForASeed) {
  const ComparedSteps steps = steps_of({1.13, 5.71, 2.37, 8.19, 3.01, 3.93, 9, 1}, 1, 2);
  const PolicyComparison result = compare_steps(steps, 7);
  const Estimate& seen = result.rows[0].e_seen_mps;
  ASSERT_TRUE(seen.low && seen.high);
  EXPECT_LT(*seen.low, seen.mean);
  EXPECT_GT(*seen.high, seen.mean);
  EXPECT_GE(*seen.low, 1);
  EXPECT_LE(*seen.high, 9);
  EXPECT_EQ(compare_steps(steps, 7).rows[0].e_seen_mps.low, seen.low);
  EXPECT_NE(compare_steps(steps, 8).rows[0].e_seen_mps.low, seen.low);
}

// From frame to frame errors differ by far more than from policy to policy: only pairs tell.
TEST(Comparison, TheConclusionGoesByDifferencesWithinEachFrame) {
  const PolicyComparison sure = compare_steps(steps_of({1, 100, 2, 900, 3, 50}, 1, 1.1), 1);
  EXPECT_NE(sure.conclusion.find("perceptual: mean E_seen"), std::string::npos) << sure.conclusion;
  EXPECT_NE(sure.conclusion.find("9.1 % below random"), std::string::npos) << sure.conclusion;
  EXPECT_TRUE(sure.conclusion.ends_with(": sure")) << sure.conclusion;
  ComparedSteps mixed = steps_of({1, 2, 3, 4, 5, 6}, 1, 1.1);
  for (std::size_t frame = 0; frame < 6; frame += 2) {
    for (std::size_t b = 0; b < 2; ++b) {
      std::swap(mixed.steps[frame * 4 + b], mixed.steps[frame * 4 + 2 + b]);
    }
  }
  const PolicyComparison unsure = compare_steps(mixed, 1);
  EXPECT_NE(unsure.conclusion.find("cannot be told apart"), std::string::npos) << unsure.conclusion;
}

// Differences of one sign have an interval without 0 however few they are.
TEST(Comparison, FewerThanSixFramesConcludeNothing) {
  const PolicyComparison five = compare_steps(steps_of({1, 2, 3, 4, 5}, 1, 2), 1);
  EXPECT_TRUE(five.too_few);
  EXPECT_FALSE(five.sure);
  EXPECT_TRUE(five.conclusion.ends_with(", 5 frames): too few states")) << five.conclusion;
  EXPECT_NE(five.conclusion.find("95 % interval"), std::string::npos) << five.conclusion;
  const PolicyComparison six = compare_steps(steps_of({1, 2, 3, 4, 5, 6}, 1, 2), 1);
  EXPECT_FALSE(six.too_few);
  EXPECT_TRUE(six.sure);
  EXPECT_TRUE(six.conclusion.ends_with(": sure")) << six.conclusion;
}

TEST(Comparison, OneFrameHasNoInterval) {
  const PolicyComparison one = compare_steps(steps_of({3}, 1, 2), 1);
  EXPECT_FALSE(one.sure);
  EXPECT_EQ(one.conclusion,
            "perceptual: mean E_seen 2.25 m/s over the budgets, 50.0 % below random (1 frame): too few states");
  for (const ComparisonRow& row : one.rows) {
    for (const Estimate* estimate : {&row.e_mps, &row.e_rel, &row.e_seen_mps})
      EXPECT_FALSE(estimate->low || estimate->high);
  }
  EXPECT_FALSE(one.areas[0].e_seen_mps.low);
  EXPECT_TRUE(compare_steps(steps_of({3, 3}, 1, 2), 1).rows[0].e_mps.low);
}

TEST(Comparison, AFrameCountsForAllPoliciesOrForNone) {
  ComparedSteps steps = steps_of({1, 2, 1000, 3000}, 1, 2);
  steps.steps[2 * 4 + 3].converged = false;
  steps.steps[3 * 4].e_seen_mps.reset();
  const PolicyComparison result = compare_steps(steps, 1);
  EXPECT_EQ(result.frames, 2U);
  EXPECT_EQ(result.not_converged, 1U);
  EXPECT_EQ(result.undefined, 1U);
  EXPECT_DOUBLE_EQ(result.rows[0].e_seen_mps.mean, 1.5);
  for (ComparedStep& step : steps.steps) step.converged = false;
  EXPECT_EQ(compare_steps(steps, 1).conclusion, "no frame could be compared");
  EXPECT_TRUE(compare_steps(steps, 1).rows.empty());
}

TEST(Comparison, RegretIsWhatThePolicyHasMoreThanTheOracleWhichNoConclusionIsAbout) {
  const PolicyComparison result = compare_steps(steps_of({1, 2, 3}, 2, 1, kOraclePolicy), 1);
  EXPECT_DOUBLE_EQ(result.rows[0].regret_mps.value(), 2);
  EXPECT_DOUBLE_EQ(result.rows[1].regret_mps.value(), 1);
  EXPECT_EQ(result.rows[2].regret_mps.value(), 0);
  EXPECT_DOUBLE_EQ(result.areas[0].regret_mps.value(), 1.5);
  EXPECT_EQ(result.conclusion, "perceptual: mean E_seen 3 m/s over the budgets");
}

ComparisonDocument document(const std::vector<double>& frames = {1, 2, 3}) {
  ComparisonDocument document;
  document.scene = "a <b> & c";
  document.budget_unit = "work_units";
  document.clock = "work";
  document.result = compare_steps(steps_of(frames, 1, 2), 1);
  return document;
}

TEST(ComparisonDocument, HasARowForEachPolicyAndBudget) {
  const auto json = nlohmann::json::parse(comparison_json(document()));
  EXPECT_EQ(json.at("schema"), "poise.compare/1");
  ASSERT_EQ(json.at("rows").size(), 4U);
  for (const char* member : {"scene", "policy", "budget", "budget_unit", "frames", "E", "E_rel", "E_seen", "E_seen_low",
                             "E_seen_high", "regret"}) {
    EXPECT_TRUE(json.at("rows")[3].contains(member)) << member;
  }
  EXPECT_EQ(json.at("rows")[3].at("E_seen"), 2);
  EXPECT_TRUE(json.at("rows")[3].at("regret").is_null());
  const std::string csv = comparison_csv(document());
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5);
}

TEST(ComparisonDocument, HasNoIntervalOfOneFrame) {
  const ComparisonDocument one = document({1});
  const auto json = nlohmann::json::parse(comparison_json(one));
  for (const char* member : {"E_low", "E_high", "E_rel_low", "E_rel_high", "E_seen_low", "E_seen_high"})
    EXPECT_TRUE(json.at("rows")[0].at(member).is_null()) << member;
  EXPECT_TRUE(json.at("areas")[0].at("E_seen_low").is_null());
  EXPECT_TRUE(json.at("areas")[0].at("E_seen_high").is_null());
  EXPECT_NE(comparison_csv(one).find(",1,2,,,0.5,,,1,,,"), std::string::npos) << comparison_csv(one);
  const std::string table = comparison_table(one);
  EXPECT_NE(table.find("        1         -         -"), std::string::npos) << table;
  const auto two = nlohmann::json::parse(comparison_json(document({1, 2})));
  EXPECT_TRUE(two.at("rows")[0].at("E_seen_low").is_number());
}

TEST(ComparisonDocument, TheTableEndsWithTheConclusion) {
  const ComparisonDocument d = document();
  EXPECT_TRUE(comparison_table(d).ends_with("\n" + d.result.conclusion + "\n"));
}

}  // namespace
}  // namespace poise::io
