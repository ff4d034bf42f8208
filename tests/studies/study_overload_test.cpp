// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "scene/temporary_folder.h"
#include "studies/study_overload.h"

namespace poise::testing {
namespace {

using nlohmann::json;

void expect_refused(std::vector<std::string> arguments, int code, const std::string& message) {
  arguments.insert(arguments.begin(), {"study", "overload"});
  const CommandResult result = poise_command(arguments);
  EXPECT_EQ(result.exit_code, code) << message;
  EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
}

TEST(StudyOverload, ByTheWorkClockHasARowForEachDemandUpAndBackAndTheLoopOfEachDrive) {
  const CommandResult result = poise_command({"study", "overload", "--clock", "work", "--bodies", "12", "--most", "2",
                                              "--settle", "100", "--hold", "10", "--threads", "1", "--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json study = json::parse(result.out, nullptr, false);
  EXPECT_EQ(study.at("schema"), "poise.overload/1");
  EXPECT_EQ(study.at("clock"), "work");
  EXPECT_EQ(study.at("shake_mps"), 0.5);
  ASSERT_EQ(study.at("rows").size(), 2U * 10U);
  const json& loops = study.at("loops");
  ASSERT_EQ(loops.size(), 2U);
  for (std::size_t i = 0; i < 20; ++i) {
    const json& row = study.at("rows")[i];
    const bool population = i >= 10;
    EXPECT_EQ(row.at("drive"), population ? "population" : "deadline");
    EXPECT_EQ(row.at("way"), i % 10 < 5 ? "up" : "back");
    EXPECT_EQ(row.at("frames"), 10);
    EXPECT_TRUE(row.at("deadline_ms").is_null());
    EXPECT_TRUE(row.at("infeasible").is_null()) << "the work clock has no late frames";
    EXPECT_GE(row.at("left_share"), 0.0);
    EXPECT_LE(row.at("left_share"), 1.0);
    const double demand = row.at("demand").get<double>();
    const double unit = loops[population ? 1 : 0].at("unit_work").get<double>();
    EXPECT_NEAR(row.at("budget_work").get<double>(), population ? unit : unit / demand, 0.5);
    EXPECT_TRUE(population || row.at("bodies") == 12);
  }
  EXPECT_EQ(study.at("rows")[0].at("demand"), 0.5);
  EXPECT_EQ(study.at("rows")[5].at("demand"), 2.0);
  EXPECT_EQ(study.at("rows")[10].at("bodies"), 6);
  EXPECT_EQ(study.at("rows")[15].at("bodies"), 24);
  for (const json& loop : loops) {
    EXPECT_TRUE(loop.at("level_mean").is_number());
    EXPECT_TRUE(loop.at("potential_relative_at_demand").is_number());
    EXPECT_TRUE(loop.at("e_seen_mps").is_null()) << "no reference was asked for";
    EXPECT_TRUE(loop.at("recovery_frames").is_number_unsigned() || loop.at("recovery_frames") == "never");
  }
}

TEST(StudyOverload, UnderADeadlineCountsLateFramesAndMeasuresTheErrorWhereAsked) {
  const TemporaryFolder folder;
  const CommandResult result = poise_command({"study",
                                              "overload",
                                              "--drive",
                                              "deadline",
                                              "--bodies",
                                              "10",
                                              "--most",
                                              "1",
                                              "--settle",
                                              "60",
                                              "--hold",
                                              "10",
                                              "--reference-every",
                                              "5",
                                              "--threads",
                                              "1",
                                              "--quiet",
                                              "--json",
                                              folder.file("o.json"),
                                              "--markdown",
                                              folder.file("o.md")});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.out, "");
  const json study = json::parse(contents(folder.file("o.json")), nullptr, false);
  ASSERT_EQ(study.at("rows").size(), 6U);
  const double unit_ms = study.at("loops")[0].at("unit_ms").get<double>();
  for (const json& row : study.at("rows")) {
    EXPECT_NEAR(row.at("deadline_ms").get<double>(), unit_ms / row.at("demand").get<double>(), 1e-5);
    EXPECT_TRUE(row.at("budget_work").is_null());
    const std::uint64_t late = row.at("infeasible").get<std::uint64_t>() + row.at("machine").get<std::uint64_t>() +
                               row.at("own").get<std::uint64_t>();
    EXPECT_LE(late, 10U);
    EXPECT_TRUE(row.at("e_seen_mps").is_number() || row.at("e_seen_mps").is_null())
        << "null where a step under way put the references off";
  }
  const std::string markdown = contents(folder.file("o.md"));
  EXPECT_NE(markdown.find("| driven | way | demand |"), std::string::npos);
  EXPECT_NE(markdown.find("frames until levels were back |"), std::string::npos);
}

TEST(StudyOverload, SaysNeverWhereLevelsDoNotComeBack) {
  app::OverloadSettings settings;
  settings.hold = 20;
  settings.steps = simulation::overload_steps(0.5, 2);
  app::OverloadDrive drive;
  simulation::RunFrame full;
  full.report.level_histogram[2] = 10;
  simulation::RunFrame coarse;
  coarse.report.level_histogram[0] = 10;
  drive.unlimited.assign(200, full);
  drive.frames.assign(100, full);
  drive.frames.resize(200, coarse);
  io::StudyTable table;
  app::add_overload_part(app::overload_part(settings, drive), table);
  EXPECT_EQ(std::get<std::string>(table.summary->rows[0].back()), "never");
  // Back in the fifth frame after demand fell to 1, which is the eighth step of ten.
  for (std::size_t i = 7 * 20 + 5; i < 200; ++i) drive.frames[i] = full;
  app::add_overload_part(app::overload_part(settings, drive), table);
  EXPECT_EQ(std::get<std::uint64_t>(table.summary->rows[1].back()), 5U);
  drive.unlimited.assign(200, simulation::RunFrame{});
  io::StudyTable none;
  app::add_overload_part(app::overload_part(settings, drive), none);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(none.summary->rows[0].back())) << "there was none to come back to";
  EXPECT_EQ(table.rows.size(), 20U);
  for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.columns.size());
  for (const auto& row : table.summary->rows) EXPECT_EQ(row.size(), table.summary->columns.size());
}

TEST(StudyOverload, RefusesWhatHasNoMeaning) {
  expect_refused({"--drive", "gravity"}, 2, "--drive");
  expect_refused({"--clock", "sun"}, 2, "--clock");
  expect_refused({"--most", "0.5"}, 2, "--most");
  expect_refused({"--bodies", "0"}, 2, "--bodies");
  expect_refused({"--hold", "9"}, 2, "--hold");
  expect_refused({"--settle", "0"}, 2, "--settle");
  expect_refused({"--shake", "-1"}, 2, "--shake");
  expect_refused(
      {"--hold", "20", "--reference-every", "11"}, 2,
      "--reference-every 11: must be at most half of --hold 20, so that one is due in the second half of each step");
  expect_refused({"--json", "-", "--markdown", "-"}, 2, "only one of --json and --markdown");
  expect_refused({"--picture", "loop.gif"}, 2, "loop.gif");
  expect_refused({"--scene", "two-body"}, 3, "has no generators");
  expect_refused({"--json", "no/such/folder/o.json"}, 4, "cannot be written");
}

}  // namespace
}  // namespace poise::testing
