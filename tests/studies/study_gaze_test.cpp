// SPDX-License-Identifier: MIT
#include "studies/study_gaze.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::app {
namespace {

using nlohmann::json;

Scene jacks() { return read_scene(POISE_SOURCE_DIR "/scenes/jacks.json").value(); }

SceneRunOptions one_thread() {
  SceneRunOptions options;
  options.world.executor = ExecutorKind::Serial;
  options.world.threads = 1;
  options.world.max_front_entries = 1U << 18U;
  return options;
}

GazeSettings small() {
  GazeSettings settings;
  settings.bodies = 500;
  settings.settle = 200;
  settings.states = 3;
  settings.every = 8;
  settings.jumps = 4;
  settings.hold = 20;
  settings.shake.speed_mps = 4;
  return settings;
}

void ignore(double /*share*/) {}

const GazeRun& small_run() {
  static const GazeRun run = [] {
    Result<GazeRun> made = run_gaze(jacks(), one_thread(), small(), ignore);
    EXPECT_TRUE(made);
    return made.value_or(GazeRun{});
  }();
  return run;
}

TEST(Gaze, LeavesLessErrorWhereItIsThanAtTheSameBodiesWhenItIsElsewhere) {
  const GazeRun& run = small_run();
  ASSERT_EQ(run.states.size(), 3U);
  const NearRatio all = near_ratios(run.states, 1).back();
  EXPECT_GT(all.bodies, 100U);
  ASSERT_TRUE(all.ratio);
  EXPECT_LT(*all.ratio, 0.95);
  EXPECT_LT(*all.full_e_mps, *all.e_mps) << "a quarter of the work leaves something";
}

TEST(Gaze, ChangesNothingIfTheCueHasNoWeight) {
  GazeSettings settings = small();
  settings.bodies = 100;
  settings.policy.eccentricity = 0;
  settings.jumps = 0;
  const Result<GazeRun> run = run_gaze(jacks(), one_thread(), settings, ignore);
  ASSERT_TRUE(run);
  EXPECT_TRUE(run.value().jumps.empty());
  const NearRatio all = near_ratios(run.value().states, 1).back();
  ASSERT_TRUE(all.ratio);
  EXPECT_EQ(*all.ratio, 1);
  EXPECT_EQ(all.low, 1);
  EXPECT_EQ(all.high, 1);
}

TEST(Gaze, IsFollowedByTheLevelsAfterAJump) {
  const GazeRun& run = small_run();
  ASSERT_EQ(run.jumps.size(), 4U);
  EXPECT_EQ(run.jumps[0].at_new.size(), 40U);
  const ServedFigures served = served_figures(run.jumps, &PairLevels::level_mean);
  EXPECT_GT(served.settled, served.before + 0.05);
  const std::vector<double> near_new = mean_over_jumps(run.jumps, &GazeJump::at_new, &PairLevels::level_mean);
  EXPECT_GT(near_new[20], near_new[19] + 0.05) << "in the first frame with the new gaze";
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(run.jumps[0].at_new[20 + i].pairs, run.jumps[1].at_old[i].pairs)
        << "where the first jump goes to is where the second one comes from";
  }
}

TEST(Gaze, GivesTheSameBitsOnTwoThreads) {
  SceneRunOptions two;
  two.world.threads = 2;
  two.world.max_front_entries = 1U << 18U;
  const Result<GazeRun> parallel = run_gaze(jacks(), two, small(), ignore);
  ASSERT_TRUE(parallel);
  io::StudyTable one_table, two_table;
  add_gaze_tables(small_run(), 1, one_table);
  add_gaze_tables(parallel.value(), 1, two_table);
  EXPECT_EQ(io::study_json(one_table), io::study_json(two_table));
}

TEST(StudyGaze, WritesItsTablesAndItsPicture) {
  const testing::TemporaryFolder folder;
  const testing::CommandResult result = testing::poise_command({"study",
                                                                "gaze",
                                                                "--bodies",
                                                                "60",
                                                                "--settle",
                                                                "120",
                                                                "--seeds",
                                                                "2",
                                                                "--states",
                                                                "2",
                                                                "--every",
                                                                "4",
                                                                "--jumps",
                                                                "2",
                                                                "--hold",
                                                                "20",
                                                                "--threads",
                                                                "1",
                                                                "--quiet",
                                                                "--json",
                                                                folder.file("g.json"),
                                                                "--markdown",
                                                                folder.file("g.md"),
                                                                "--picture",
                                                                folder.file("g.png")});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json study = json::parse(testing::contents(folder.file("g.json")), nullptr, false);
  EXPECT_EQ(study.at("schema"), "poise.gaze/1");
  EXPECT_EQ(study.at("rows").size(), 15U);
  EXPECT_EQ(study.at("near").size(), 4U);
  EXPECT_EQ(study.at("after_jump").size(), 7U);
  EXPECT_EQ(study.at("after_jump")[0].at("frame"), "-1");
  EXPECT_EQ(study.at("jump_frames").size(), 40U);
  EXPECT_EQ(study.at("served").size(), 2U);
  EXPECT_EQ(study.at("cells").size(), 3U * 24U * 14U);
  EXPECT_EQ(study.at("states").get<int>() + study.at("states_not_converged").get<int>(), 4);
  const std::string markdown = testing::contents(folder.file("g.md"));
  EXPECT_NE(markdown.find("| gaze | degrees from it |"), std::string::npos) << markdown;
  EXPECT_NE(markdown.find("| served by |"), std::string::npos) << markdown;
  EXPECT_EQ(markdown.find("column"), std::string::npos) << "cells are for JSON and the picture";
  EXPECT_EQ(testing::contents(folder.file("g.png")).substr(1, 3), "PNG");
}

void expect_refused(std::vector<std::string> arguments, int code, const std::string& message) {
  arguments.insert(arguments.begin(), {"study", "gaze"});
  const testing::CommandResult result = testing::poise_command(arguments);
  EXPECT_EQ(result.exit_code, code) << message;
  EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
}

TEST(StudyGaze, RefusesWhatItCannotDo) {
  expect_refused({"--budget", "0"}, 2, "--budget");
  expect_refused({"--budget", "101"}, 2, "--budget");
  expect_refused({"--hold", "19"}, 2, "--hold");
  expect_refused({"--states", "0"}, 2, "--states");
  expect_refused({"--weight", "eccentricity=-1"}, 2, "--weight: eccentricity = -1, must be from 0 to 10");
  expect_refused({"--weight", "gaze=1"}, 2, "--weight: \"gaze=1\", must be CUE=VALUE");
  expect_refused({"--json", "-", "--markdown", "-"}, 2, "only one of --json and --markdown");
  expect_refused({"--scene", "no-such-scene"}, 3, "no-such-scene");
  expect_refused({"--scene", "pour"}, 3, "has a stream");
}

TEST(StudyGaze, RefusesASceneInWhichThereIsNothingToRefine) {
  const testing::TemporaryFolder folder;
  std::ofstream(folder.file("apart.json")) << R"({"name": "apart", "dt_s": 0.01, "gravity_mps2": [0, 0, 0],
    "materials": {"m": {}}, "shapes": {"ball": {"sphere": {"radius_m": 0.5}}},
    "generators": [{"grid": {"shapes": ["ball"], "material": "m", "count": [2, 1, 1], "origin_m": [0, 0, 0],
                             "spacing_m": 9}}]})";
  expect_refused({"--scene", folder.file("apart.json"), "--bodies", "2", "--settle", "1", "--shake", "0"}, 3,
                 "has nothing to refine");
}

}  // namespace
}  // namespace poise::app
