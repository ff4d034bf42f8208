// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/command.h"
#include "studies/study_error_time.h"

namespace poise::testing {
namespace {

using nlohmann::json;

CommandResult error_time(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"study", "error-time", "--quiet"});
  return poise_command(arguments);
}

const json& row_of(const json& study, const std::string& group, double setting) {
  const auto found = std::ranges::find_if(study.at("rows"), [&](const json& row) {
    return row.at("group") == group && row.at("setting").get<double>() == setting;
  });
  EXPECT_NE(found, study.at("rows").end()) << group << ' ' << setting;
  return *found;
}

TEST(ErrorTime, DeeperLevelsAreTruerAndEnginesComeToTheirOwnLimit) {
  const CommandResult result =
      error_time({"--bodies", "60", "--warmup", "90", "--states", "3", "--every", "5", "--history", "3", "--policies",
                  "perceptual", "--deadlines", "1000", "--iterations", "1,400", "--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json study = json::parse(result.out);
  EXPECT_EQ(study.at("schema"), "poise.error-time/1");
  ASSERT_EQ(study.at("states").get<int>(), 3);
  const double coarse = row_of(study, "levels", 0).at("e_rel").get<double>();
  const double deep = row_of(study, "levels", 2).at("e_rel").get<double>();
  EXPECT_LT(deep, 0.5 * coarse);
  // With all the time there is every pair comes to its finest level.
  EXPECT_LT(row_of(study, "perceptual", 1000).at("e_rel").get<double>(), 0.5 * coarse);
  EXPECT_TRUE(row_of(study, "perceptual", 1000).at("own_e_rel").is_null());
  for (const json& row : study.at("rows")) EXPECT_GT(row.at("time_p50_ms").get<double>(), 0) << row;
  if (study.at("engines") == "none are built in") GTEST_SKIP() << "libbullet-dev or libode-dev is not installed";
  for (const char* engine : {"bullet", "ode"}) {
    const double once = row_of(study, engine, 1).at("own_e_rel").get<double>();
    EXPECT_GT(once, 0.1) << engine;
    EXPECT_LT(row_of(study, engine, 400).at("own_e_rel").get<double>(), 0.5 * once) << engine;
    // They model impacts otherwise, but not another world.
    EXPECT_LT(row_of(study, engine, 400).at("e_rel").get<double>(), 2) << engine;
  }
}

TEST(ErrorTime, AnEngineDoesTheSameFromAStateWhateverItDidBefore) {
  const CommandResult result =
      error_time({"--bodies", "60", "--warmup", "95", "--states", "2", "--every", "5", "--history", "3", "--policies",
                  "fifo", "--deadlines", "50", "--iterations", "20,4,20,20", "--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json study = json::parse(result.out);
  std::map<std::string, std::vector<json>> rows;
  for (const json& row : study.at("rows")) {
    if (row.at("unit") == "iterations" && row.at("setting") == 20) rows[row.at("group")].push_back(row);
  }
  for (const auto& [engine, same] : rows) {
    ASSERT_EQ(same.size(), 3U) << engine;
    for (const json& row : same) {
      EXPECT_EQ(row.at("e_rel"), same[0].at("e_rel")) << engine;
      EXPECT_EQ(row.at("own_e_rel"), same[0].at("own_e_rel")) << engine;
    }
  }
  if (study.at("engines") == "none are built in") GTEST_SKIP() << "libbullet-dev or libode-dev is not installed";
  EXPECT_EQ(rows.size(), 2U);
}

TEST(ErrorTime, LeavesOutEnginesThatCannotHaveTheSceneAndSaysWhy) {
  const CommandResult result =
      error_time({"--scene", "pile", "--bodies", "40", "--warmup", "120", "--states", "1", "--every", "1", "--history",
                  "1", "--policies", "fifo", "--deadlines", "50", "--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json study = json::parse(result.out);
  for (const json& row : study.at("rows")) EXPECT_NE(row.at("unit"), "iterations") << row;
  const std::string why = study.at("engines");
  EXPECT_TRUE(why == "none are built in" || why.find("one shape of spheres") != std::string::npos) << why;
}

io::ComparedStep step_of(double e_rel, double time_ms, bool converged = true) {
  io::ComparedStep step;
  step.converged = converged;
  step.e_mps = step.e_rel = step.e_seen_mps = e_rel;
  step.time_ms = time_ms;
  return step;
}

TEST(ErrorTime, RowsOfAGroupAreOverTheStatesInWhichAllOfThemCount) {
  app::ErrorTimeRun run;
  const auto add = [&](const char* group, double setting, std::vector<io::ComparedStep> steps) -> app::MethodRun& {
    app::MethodRun& method = run.methods.emplace_back();
    method.method = {group, app::SettingKind::Iterations, setting};
    method.steps = std::move(steps);
    return method;
  };
  add("one", 4, {step_of(0.1, 1), step_of(0.3, 2), step_of(100, 1000, false)}).own_e_rel = {0.5, 0.7, 90.0};
  add("one", 8, {step_of(0.2, 3), step_of(0.4, 4), step_of(0.1, 5)}).own_e_rel = {std::nullopt, 0.2, 0.1};
  add("two", 4, {step_of(0.5, 6), step_of(0.5, 6), step_of(0.8, 9)});
  const io::StudyTable table = app::error_time_table(run, 1);
  const auto number = [&](std::size_t row, const char* name) {
    const auto at = std::ranges::find(table.columns, name, &io::StudyColumn::name);
    const io::StudyCell& cell = table.rows.at(row).at(static_cast<std::size_t>(at - table.columns.begin()));
    if (const auto* whole = std::get_if<std::uint64_t>(&cell)) return static_cast<double>(*whole);
    return std::holds_alternative<double>(cell) ? std::get<double>(cell) : -1.0;
  };
  ASSERT_EQ(table.rows.size(), 3U);
  EXPECT_EQ(number(0, "states"), 2);
  EXPECT_EQ(number(1, "states"), 2) << "the state that does not count for the other setting";
  EXPECT_EQ(number(2, "states"), 3);
  EXPECT_NEAR(number(0, "e_rel"), 0.2, 1e-12);
  EXPECT_NEAR(number(1, "e_rel"), 0.3, 1e-12);
  EXPECT_NEAR(number(0, "own_e_rel"), 0.6, 1e-12);
  EXPECT_NEAR(number(1, "own_e_rel"), 0.2, 1e-12) << "nothing changed in one state";
  EXPECT_EQ(number(2, "own_e_rel"), -1);
  EXPECT_LE(number(0, "time_p75_ms"), 2);
  EXPECT_EQ(number(2, "time_p50_ms"), 6);
  const std::vector<app::LineChart> charts = app::error_time_charts(table);
  ASSERT_EQ(charts.size(), 2U);
  ASSERT_EQ(charts[0].lines.size(), 2U);
  ASSERT_EQ(charts[0].lines[0].points.size(), 2U);
  EXPECT_NEAR(charts[0].lines[0].points[1].y, 0.3, 1e-12);
  EXPECT_TRUE(charts[0].lines[0].points[1].low.has_value());
}

TEST(ErrorTime, OneStateHasNoIntervalAndNoBand) {
  app::ErrorTimeRun run;
  run.methods.emplace_back().method = {"one", app::SettingKind::Iterations, 4};
  run.methods.back().steps = {step_of(0.1, 1)};
  const io::StudyTable table = app::error_time_table(run, 1);
  for (const char* name : {"e_rel_low", "e_rel_high", "e_seen_low_mps", "e_seen_high_mps"}) {
    const auto at = std::ranges::find(table.columns, name, &io::StudyColumn::name) - table.columns.begin();
    EXPECT_TRUE(std::holds_alternative<std::monostate>(table.rows.at(0).at(static_cast<std::size_t>(at)))) << name;
  }
  const std::vector<app::LineChart> charts = app::error_time_charts(table);
  ASSERT_EQ(charts[0].lines[0].points.size(), 1U);
  EXPECT_FALSE(charts[0].lines[0].points[0].low.has_value());
}

TEST(ErrorTime, RefusesStatesWithoutContactsAndIterationsOutOfRange) {
  const CommandResult before = error_time({"--bodies", "8", "--warmup", "0", "--states", "1", "--every", "1",
                                           "--history", "1", "--deadlines", "5", "--iterations", "1"});
  EXPECT_EQ(before.exit_code, 3);
  EXPECT_NE(before.error.find("take a later --warmup"), std::string::npos) << before.error;
  const CommandResult bad = error_time({"--iterations", "0"});
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_NE(bad.error.find("--iterations"), std::string::npos) << bad.error;
}

}  // namespace
}  // namespace poise::testing
