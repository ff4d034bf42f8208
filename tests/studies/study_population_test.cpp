// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "scene/temporary_folder.h"
#include "studies/study_population.h"

namespace poise::testing {
namespace {

using nlohmann::json;

void expect_refused(std::vector<std::string> arguments, int code, const std::string& message) {
  arguments.insert(arguments.begin(), {"study", "population"});
  const CommandResult result = poise_command(arguments);
  EXPECT_EQ(result.exit_code, code) << message;
  EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
}

// On one thread, with the JSON on the standard output.
CommandResult population(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {"study", "population", "--threads", "1", "--quiet", "--json", "-"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return poise_command(words);
}

TEST(StudyPopulation, ByTheWorkClockHasARowForEachPopulationFromProcessesOfTheirOwn) {
  const CommandResult result =
      population({"--clock", "work", "--budget-work", "100", "--bodies", "24,12", "--frames", "60", "--sleeping",
                  "--reference-every", "30", "--reference-most-bodies", "12"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json study = json::parse(result.out, nullptr, false);
  EXPECT_EQ(study.at("schema"), "poise.population/1");
  EXPECT_EQ(study.at("budget_work"), 100);
  EXPECT_TRUE(study.at("stopped_after_bodies").is_null());
  ASSERT_EQ(study.at("rows").size(), 2U);
  EXPECT_EQ(study.at("rows")[0].at("bodies"), 12) << "from small to large";
  EXPECT_EQ(study.at("rows")[1].at("bodies"), 24);
  for (const json& row : study.at("rows")) {
    EXPECT_EQ(row.at("frames"), 60);
    EXPECT_EQ(row.at("islands_wait"), false);
    EXPECT_TRUE(row.at("infeasible").is_null());
    EXPECT_GT(row.at("memory_bytes"), 100'000);
    EXPECT_DOUBLE_EQ(row.at("bytes_per_body").get<double>(),
                     row.at("memory_bytes").get<double>() / row.at("bodies").get<double>());
    EXPECT_GT(row.at("load_s"), 0.0);
  }
  EXPECT_TRUE(study.at("rows")[0].at("e_seen_mps").is_number());
  EXPECT_TRUE(study.at("rows")[1].at("e_seen_mps").is_null()) << "beyond --reference-most-bodies";
}

TEST(StudyPopulation, UnderADeadlineRunsEachPopulationWithAndWithoutIslandsThatWait) {
  const CommandResult result = population({"--bodies", "10", "--frames", "9", "--deadline", "1000"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json study = json::parse(result.out, nullptr, false);
  EXPECT_EQ(study.at("deadline_ms"), 1000.0);
  ASSERT_EQ(study.at("rows").size(), 2U);
  EXPECT_EQ(study.at("rows")[0].at("islands_wait"), true);
  EXPECT_EQ(study.at("rows")[1].at("islands_wait"), false);
  EXPECT_EQ(study.at("rows")[0].at("infeasible"), 0);
  EXPECT_EQ(study.at("rows")[0].at("infeasible_last"), 0);
}

TEST(StudyPopulation, LeavesOutLargerPopulationsOnceTheMedianFrameIsTwelveDeadlinesLate) {
  EXPECT_FALSE(app::too_late(13, 1));
  EXPECT_TRUE(app::too_late(13.1, 1));
  // No frame takes less than 12 nanoseconds.
  const CommandResult result =
      population({"--bodies", "10,20", "--frames", "3", "--deadline", "0.000001", "--hold", "off"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error,
            "poise study population: with 10 bodies the median frame is more than 12 deadlines late; larger "
            "populations were left out\n");
  const json study = json::parse(result.out, nullptr, false);
  EXPECT_EQ(study.at("rows").size(), 1U);
  EXPECT_EQ(study.at("stopped_after_bodies"), 10);
  EXPECT_EQ(study.at("rows")[0].at("infeasible").get<int>() + study.at("rows")[0].at("machine").get<int>() +
                study.at("rows")[0].at("own").get<int>(),
            3);
}

TEST(StudyPopulation, CountsTheLastThirdByItselfAndMemoryByTheMostPairs) {
  std::vector<simulation::RunFrame> frames(9);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    FrameReport& report = frames[i].report;
    report.level_histogram[i < 6 ? 1 : 2] = 10;
    report.cause = i == 1 || i == 7 ? MissCause::Infeasible : MissCause::None;
    report.lateness = Nanoseconds(report.cause == MissCause::None ? 0 : 5);
    report.times.total = Nanoseconds(1'000'000 * (i + 1));
    report.candidate_pairs = i == 4 ? 50 : 10;
    report.degraded.bodies_held = i == 8 ? 18 : 0;
  }
  ReferenceFigures& reference = frames[8].report.reference.emplace();
  reference.e_seen_mps = 0.3;
  reference.change_mps = 1.5;
  reference.converged = true;
  ReferenceFigures& without_end = frames[7].report.reference.emplace();
  without_end = reference;
  without_end.e_seen_mps = 1.2;
  without_end.converged = false;
  app::StudyRun run;
  run.bodies = 20;
  const std::vector<io::StudyCell> row = app::population_row(run, {2500, 1000}, frames);
  const std::vector<io::StudyColumn> columns = app::population_columns();
  ASSERT_EQ(row.size(), columns.size());
  const auto number = [&](const std::string& name) {
    const auto at = std::ranges::find(columns, name, &io::StudyColumn::name) - columns.begin();
    const io::StudyCell& cell = row[static_cast<std::size_t>(at)];
    const auto* whole = std::get_if<std::uint64_t>(&cell);
    return whole != nullptr ? static_cast<double>(*whole) : std::get<double>(cell);
  };
  EXPECT_EQ(number("infeasible"), 2);
  EXPECT_EQ(number("infeasible_last"), 1);
  EXPECT_EQ(number("own"), 0);
  EXPECT_EQ(number("p50_ms"), 5);
  EXPECT_EQ(number("p50_last_ms"), 8);
  EXPECT_EQ(number("level_last"), 2);
  EXPECT_EQ(number("held_mean"), 2);
  EXPECT_NEAR(number("e_seen_mps"), 0.3, 1e-15) << "of references that have converged";
  EXPECT_NEAR(number("e_seen_rel"), 0.2, 1e-15);
  EXPECT_EQ(number("bytes_per_body"), 50);
  EXPECT_EQ(number("bytes_per_pair"), 20);
  EXPECT_EQ(number("load_s"), 2.5);
}

TEST(StudyPopulation, RefusesWhatHasNoMeaning) {
  expect_refused({"--budget-work", "5"}, 2, "--budget-work needs --clock work");
  expect_refused({"--clock", "work"}, 2, "--clock work needs --budget-work");
  expect_refused({"--clock", "work", "--budget-work", "5", "--deadline", "4"}, 2,
                 "--deadline has no meaning with --clock work");
  expect_refused({"--clock", "work", "--budget-work", "5", "--hold", "on"}, 2,
                 "--hold on has no meaning with --clock work");
  expect_refused({"--reference-most-bodies", "5"}, 2, "--reference-most-bodies needs --reference-every");
  expect_refused({"--bodies", "0"}, 2, "--bodies");
  expect_refused({"--bodies", "2000000"}, 2, "--bodies");
  expect_refused({"--hold", "maybe"}, 2, "--hold");
  expect_refused({"--frames", "2"}, 2, "--frames");
  expect_refused({"--scene", "two-body"}, 3, "has no generators");
  expect_refused({"--json", "no/such/folder/p.json"}, 4, "cannot be written");
}

TEST(StudyPopulation, SaysWhichPopulationsProcessFailed) {
  const TemporaryFolder folder;
  const std::string scene = folder.file("s.json");
  // Its mesh is not there: that is told when the scene is loaded, in the process of the first population.
  std::ofstream(scene) << R"({"name": "s", "dt_s": 0.01, "gravity_mps2": [0, 0, 0], "materials": {"m": {}},
    "shapes": {"none": {"mesh": {"file": "none.obj"}}},
    "generators": [{"grid": {"shapes": ["none"], "material": "m", "count": [2, 2, 2], "origin_m": [0, 0, 0], "spacing_m": 9}}]})";
  const CommandResult result =
      poise_command({"study", "population", "--scene", scene, "--bodies", "4", "--frames", "3", "--quiet"});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.error.find("none.obj"), std::string::npos) << result.error;
  EXPECT_NE(result.error.find("poise study population: the process with 4 bodies ended with 3\n"), std::string::npos)
      << result.error;
}

}  // namespace
}  // namespace poise::testing
