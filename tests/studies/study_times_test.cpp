// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "scene/temporary_folder.h"
#include "studies/study_compliance.h"

namespace poise::testing {
namespace {

using nlohmann::json;

// A few falling balls, whose frames take microseconds.
std::string small_scene(const TemporaryFolder& folder) {
  const std::string file = folder.file("small.json");
  std::ofstream(file) << R"({"name": "small", "dt_s": 0.004, "gravity_mps2": [0, 0, -9.81], "frames": 130,
    "materials": {"m": {}}, "shapes": {"ball": {"sphere": {"radius_m": 0.5}}},
    "generators": [{"grid": {"shapes": ["ball"], "material": "m", "count": [3, 3, 3], "origin_m": [0, 0, 1], "spacing_m": 1.01}}]})";
  return file;
}

TEST(StudyTimes, ForecastPlaysEveryMethodOnTheSameFrames) {
  const TemporaryFolder folder;
  const CommandResult result = poise_command({"study", "forecast", "--scene", small_scene(folder), "--frames", "40",
                                              "--bodies", "20,30", "--alpha", "0.1", "--threads", "1", "--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json study = json::parse(result.out, nullptr, false);
  EXPECT_EQ(study.at("schema"), "poise.forecast/1");
  ASSERT_EQ(study.at("rows").size(), 10U);
  for (const json& row : study.at("rows")) {
    EXPECT_GE(row.at("exceeded"), 0.0);
    EXPECT_LE(row.at("exceeded"), 100.0);
    EXPECT_GT(row.at("reserve_over_actual"), 0.0);
    EXPECT_GE(row.at("pinball"), 0.0);
  }
}

TEST(StudyTimes, ComplianceCountsEveryReleaseOfEveryRow) {
  const TemporaryFolder folder;
  const CommandResult result = poise_command({"study", "compliance", "--scene", small_scene(folder), "--frames", "20",
                                              "--warmup", "2", "--bodies", "20", "--populations", "0.5,2", "--alpha",
                                              "0.5", "--threads", "1", "--competing-load", "--json", "-"});
  ASSERT_TRUE(result.exit_code == 0 || result.exit_code == 1) << result.error;
  const json study = json::parse(result.out, nullptr, false);
  ASSERT_EQ(study.at("rows").size(), 2U);
  EXPECT_EQ(study.at("competing_load"), true);
  EXPECT_EQ(study.at("rows")[0].at("bodies"), 10);
  EXPECT_EQ(study.at("rows")[1].at("bodies"), 40);
  bool all = true;
  for (const json& row : study.at("rows")) {
    EXPECT_GE(row.at("releases"), 20);
    const double misses = row.at("infeasible").get<double>() + row.at("machine").get<double>() +
                          row.at("overrun").get<double>() + row.at("forecast").get<double>() +
                          row.at("release").get<double>();
    EXPECT_NEAR(row.at("miss_rate").get<double>(), 100 * misses / row.at("releases").get<double>(), 1e-9);
    EXPECT_LE(row.at("own_low"), row.at("own_rate"));
    EXPECT_GE(row.at("own_high"), row.at("own_rate"));
    EXPECT_EQ(row.at("complies"), row.at("compliance") == "yes");
    all = all && row.at("compliance") != "no";
  }
  EXPECT_EQ(result.exit_code, all ? 0 : 1);
}

TEST(StudyTimes, ARowCompliesOnlyIfItIsOnTime) {
  using app::Compliance;
  simulation::MissFigures misses;
  misses.releases = 5000;
  misses.machine = 4000;
  EXPECT_EQ(app::compliance_of(misses, 0.01, std::nullopt), Compliance::Complies) << "not its fault";
  EXPECT_EQ(app::compliance_of(misses, 0.01, 0.89), Compliance::Fails) << "refinement left its time unused";
  EXPECT_EQ(app::compliance_of(misses, 0.01, 0.9), Compliance::Complies);
  misses.machine = 0;
  misses.infeasible = 60;  // 1.2 %, within the interval of 1 %
  EXPECT_EQ(app::compliance_of(misses, 0.01, 1.0), Compliance::Complies);
  misses.infeasible = 100;
  EXPECT_EQ(app::compliance_of(misses, 0.01, 1.0), Compliance::Fails) << "late is late";
  misses.infeasible = 2500;
  EXPECT_EQ(app::compliance_of(misses, 0.01, 1.0), Compliance::Fails);
  misses.infeasible = 2501;
  EXPECT_EQ(app::compliance_of(misses, 0.01, 1.0), Compliance::OutOfReach);
  for (std::uint64_t simulation::MissFigures::*own :
       {&simulation::MissFigures::overrun, &simulation::MissFigures::forecast, &simulation::MissFigures::release}) {
    simulation::MissFigures late;
    late.releases = 5000;
    late.*own = 100;
    EXPECT_EQ(app::compliance_of(late, 0.01, 1.0), Compliance::Fails);
    EXPECT_EQ(app::compliance_of(late, 0.02, 1.0), Compliance::Complies);
  }
}

TEST(StudyTimes, ConstantTimeGrowsThePopulationUpToTheLargest) {
  const TemporaryFolder folder;
  const CommandResult result =
      poise_command({"study", "constant-time", "--scene", small_scene(folder), "--frames", "5", "--warmup", "1",
                     "--deadline", "1000", "--most-bodies", "200", "--threads", "1", "--json", "-"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json study = json::parse(result.out, nullptr, false);
  ASSERT_EQ(study.at("rows").size(), 3U);
  EXPECT_EQ(study.at("rows")[1].at("bodies"), 150);
  EXPECT_EQ(study.at("rows")[2].at("bodies"), 200);
  EXPECT_GT(study.at("rows")[2].at("full_p99_ms"), 0.0);
}

TEST(StudyTimes, RefuseASceneWhosePopulationCannotBeChosen) {
  const CommandResult result = poise_command({"study", "forecast", "--scene", "two-body"});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_NE(result.error.find("has no generators"), std::string::npos) << result.error;
  EXPECT_EQ(poise_command({"study", "compliance", "--alpha", "2"}).exit_code, 2);
}

}  // namespace
}  // namespace poise::testing
