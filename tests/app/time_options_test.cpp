// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/command.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

// A few falling balls, whose frames take microseconds.
std::string small_scene(const TemporaryFolder& folder, const std::string& more = "") {
  const std::string file = folder.file("small.json");
  std::ofstream(file) << R"({"name": "small", "dt_s": 0.004, "gravity_mps2": [0, 0, -9.81], "frames": 130,)" << more
                      << R"(
    "materials": {"m": {}}, "shapes": {"ball": {"sphere": {"radius_m": 0.5}}},
    "generators": [{"grid": {"shapes": ["ball"], "material": "m", "count": [3, 3, 3], "origin_m": [0, 0, 1], "spacing_m": 1.01}}]})";
  return file;
}

json run_json(const std::vector<std::string>& more) {
  std::vector<std::string> words{"run"};
  words.insert(words.end(), more.begin(), more.end());
  words.insert(words.end(), {"--quiet", "--json", "-", "--threads", "1"});
  const CommandResult result = poise_command(words);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return json::parse(result.out, nullptr, false);
}

TEST(TimeOptions, ARenderLoadIsPartOfTheFrame) {
  const TemporaryFolder folder;
  const std::string frames = folder.file("frames.csv");
  // The load alone is longer than the deadline, so every frame is late on any machine.
  const json report = run_json(
      {small_scene(folder), "--frames", "5", "--deadline", "2", "--render-load", "3,0.5", "--frames-csv", frames});
  EXPECT_EQ(report.at("misses").at("count"), 5);
  EXPECT_EQ(report.at("misses").at("infeasible"), 5);
  EXPECT_EQ(report.at("settings").at("render_load_ms"), 3.0);
  EXPECT_EQ(report.at("settings").at("render_load_jitter_ms"), 0.5);
  EXPECT_EQ(report.at("settings").at("host_work_learned"), true);
  EXPECT_NE(contents(frames).find("host_actual_ms"), std::string::npos);
}

TEST(TimeOptions, ASceneSaysWhatItsHostDoesAndTheCommandLineOverrulesIt) {
  const TemporaryFolder folder;
  const std::string scene =
      small_scene(folder, R"("alpha": 0.05, "host_work": {"load_ms": 0.25, "jitter_ms": 0.125, "reserve_ms": 1},)");
  json report = run_json({scene, "--frames", "2"});
  EXPECT_EQ(report.at("settings").at("render_load_ms"), 0.25);
  EXPECT_EQ(report.at("settings").at("host_work_ms"), 1.0);
  EXPECT_EQ(report.at("settings").at("host_work_learned"), false);
  EXPECT_EQ(report.at("settings").at("alpha"), 0.05);
  report = run_json({scene, "--frames", "2", "--render-load", "0", "--host-work", "0.5", "--alpha", "0.2"});
  EXPECT_EQ(report.at("settings").at("render_load_ms"), 0.0);
  EXPECT_EQ(report.at("settings").at("host_work_ms"), 0.5);
  EXPECT_EQ(report.at("settings").at("alpha"), 0.2);
}

TEST(TimeOptions, WhatWasLearnedIsWhereTheNextRunBeginsUnlessItIsTurnedOff) {
  const TemporaryFolder folder;
  const std::string kept = folder.file("times");
  const std::string scene = small_scene(folder);
  const auto first = run_json({scene, "--time-priors", kept});
  EXPECT_EQ(first.at("settings").at("time_priors_frames"), 0);
  // A step that takes several frames teaches once.
  const int learned = 130 - first.at("degraded").at("frames_unfinished").get<int>();
  EXPECT_EQ(run_json({scene, "--time-priors", kept, "--frames", "3"}).at("settings").at("time_priors_frames"), learned);
  EXPECT_EQ(run_json({scene, "--no-time-priors", "--frames", "3"}).at("settings").at("time_priors_frames"), 0);
  // Nothing is stored after too few frames to learn from, or with counted work.
  EXPECT_EQ(run_json({scene, "--time-priors", kept, "--frames", "3"}).at("settings").at("time_priors_frames"), learned);
  const std::string none = folder.file("none");
  run_json({scene, "--time-priors", none, "--clock", "work"});
  EXPECT_FALSE(std::filesystem::exists(none));
}

TEST(TimeOptions, AreRefusedWithTheirRule) {
  const TemporaryFolder folder;
  const std::string scene = small_scene(folder);
  const auto refused = [&](const std::vector<std::string>& more, const std::string& message) {
    std::vector<std::string> words{"run", scene};
    words.insert(words.end(), more.begin(), more.end());
    const CommandResult result = poise_command(words);
    EXPECT_EQ(result.exit_code, 2) << message;
    EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
  };
  refused({"--render-load", "1,2"}, "--render-load = 1,2, must be MS or MS,JITTER");
  refused({"--render-load", "x"}, "--render-load = x, must be");
  refused({"--render-load", "-1"}, "--render-load");
  refused({"--render-load", "3", "--clock", "work"}, "--render-load has no meaning with --clock work");
  refused({"--alpha", "0.6"}, "--alpha");
  refused({"--alpha", "0.01", "--clock", "work"}, "--alpha has no meaning with --clock work");
  refused({"--time-priors", "x", "--no-time-priors"}, "--time-priors has no meaning with --no-time-priors");
}

}  // namespace
}  // namespace poise::testing
