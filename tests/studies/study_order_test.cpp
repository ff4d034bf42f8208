// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "studies/order_figures.h"

namespace poise::testing {
namespace {

using app::order_figures;
using app::OrderFigures;
using nlohmann::json;

// Pair 0 has levels of scores 5 and 9, pair 1 of 7 and 1, pair 2 of 6; ten units each.
FrameExplanation three_pairs() {
  FrameExplanation all;
  all.pairs.resize(3);
  all.levels = {{0, Level{1}, 10, 5, false},
                {0, Level{2}, 10, 9, false},
                {1, Level{1}, 10, 7, false},
                {1, Level{2}, 10, 1, false},
                {2, Level{1}, 10, 6, false}};
  return all;
}

FrameDecisions completed(std::initializer_list<std::uint32_t> pairs) {
  FrameDecisions decisions;
  for (const std::uint32_t pair : pairs) decisions.steps.push_back({pair, 0, RefinementStep::Kind::Completed});
  return decisions;
}

TEST(OrderFigures, NothingIsMisplacedInTheOrderOfASortedQueue) {
  const OrderFigures figures = order_figures(completed({1, 2}), three_pairs());
  EXPECT_EQ(figures.full, 50U);
  EXPECT_EQ(figures.done, 20U);
  EXPECT_EQ(figures.misplaced, 0U);
}

TEST(OrderFigures, ALevelHasItsTurnAfterThoseBeforeIt) {
  // The second level of pair 0 has the highest score of all, and comes fourth.
  EXPECT_EQ(order_figures(completed({0, 0}), three_pairs()).misplaced, 20U);
  EXPECT_EQ(order_figures(completed({1, 2, 0, 0}), three_pairs()).misplaced, 0U);
  EXPECT_EQ(order_figures(completed({1, 1, 2}), three_pairs()).misplaced, 10U);
}

TEST(OrderFigures, WhatWasBegunAndDiscardedIsNotDone) {
  FrameDecisions decisions = completed({1});
  decisions.steps.push_back({0, 0, RefinementStep::Kind::Cut});
  const OrderFigures figures = order_figures(decisions, three_pairs());
  EXPECT_EQ(figures.done, 10U);
  EXPECT_EQ(figures.misplaced, 0U);
}

json study_of(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"study", "order", "--json", "-", "--quiet"});
  const CommandResult result = poise_command(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return json::parse(result.out, nullptr, false);
}

TEST(StudyOrder, CountedWorkGoesInTheOrderOfScores) {
  const json study =
      study_of({"--bodies", "150", "--budget", "30", "--warmup", "50", "--frames", "30", "--every", "10"});
  ASSERT_EQ(study.at("rows").size(), 1U);
  const json& row = study.at("rows")[0];
  EXPECT_EQ(row.at("frames"), 3);
  EXPECT_EQ(row.at("budget_percent"), 30.0);
  EXPECT_NEAR(row.at("work_percent").get<double>(), 30.0, 1.0);
  EXPECT_LT(row.at("misplaced_percent").get<double>(), 25.0) << "what rounds of pairs cost in so small a heap";
  EXPECT_TRUE(row.at("ranking_percent").is_null());
  EXPECT_EQ(row.at("frames_left_out"), 0) << "nothing is left out by the work clock";
}

TEST(StudyOrder, WithAllTheTimeThatThereIsNothingIsMisplaced) {
  const json study = study_of({"--bodies", "60", "--deadlines", "100000", "--warmup", "40", "--frames", "2"});
  const json& row = study.at("rows")[0];
  EXPECT_EQ(row.at("work_percent"), 100.0);
  EXPECT_EQ(row.at("misplaced_percent"), 0.0);
}

TEST(StudyOrder, RefusesWhatContradicts) {
  const auto refused = [](std::vector<std::string> arguments, int code, const std::string& text) {
    arguments.insert(arguments.begin(), {"study", "order"});
    const CommandResult result = poise_command(arguments);
    EXPECT_EQ(result.exit_code, code) << text;
    EXPECT_NE(result.error.find(text), std::string::npos) << result.error;
  };
  refused({"--budget", "20", "--deadlines", "3"}, 2, "only one of --deadlines and --budget");
  refused({"--deadlines", "0"}, 2, "--deadlines");
  refused({"--bodies", "10", "--weight", "smell=1"}, 3, "smell");
}

}  // namespace
}  // namespace poise::testing
