// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "app/command.h"
#include "scene/temporary_folder.h"

/// The scenes whose bodies leave, whose camera moves and whose gaze jumps, scaled down.
namespace poise::testing {
namespace {

using nlohmann::json;
using Words = std::vector<std::string>;

// Of pour one body comes each 4 frames up to frame 480, and from frame 360 on they leave.
const Words kPour{"pour", "--bodies", "120", "--frames", "600"};
const Words kMetropolis{"metropolis", "--bodies", "150", "--frames", "200"};
const Words kStreet{"street", "--bodies", "150", "--frames", "90"};

json done(Words arguments, const Words& more) {
  arguments.insert(arguments.begin(), arguments.front() == "replay" ? 0 : 1, "run");
  arguments.insert(arguments.end(), more.begin(), more.end());
  arguments.insert(arguments.end(), {"--json", "-", "--quiet"});
  const CommandResult result = poise_command(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return json::parse(result.out, nullptr, false);
}

std::string column_of(const std::string& states, std::uint64_t frame) {
  std::string numbers;
  for (const std::string& row : lines(states)) {
    const Words row_cells = cells(row);
    if (row_cells.at(0) == std::to_string(frame)) numbers += row_cells.at(2) + " ";
  }
  return numbers;
}

class ShippedScenes : public ::testing::TestWithParam<Words> {};

TEST_P(ShippedScenes, AreReplayedToTheBitWhateverTheClockLetThemDo) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  const json run = done(GetParam(), {"--deadline", "0.3", "--threads", "2", "--executor", "threads", "--record", file,
                                     "--states", folder.file("run.csv")});
  const json replay = done({"replay", file}, {"--threads", "1", "--states", folder.file("again.csv")});
  EXPECT_EQ(replay.at("state_hash"), run.at("state_hash"));
  EXPECT_EQ(replay.at("same"), true);
  EXPECT_EQ(replay.at("whole"), true);
  EXPECT_TRUE(contents(folder.file("again.csv")) == contents(folder.file("run.csv")));
}

TEST_P(ShippedScenes, GiveTheSameStateOnAnyThreads) {
  const Words work{"--clock", "work", "--budget-work", "20"};
  std::set<std::string> hashes;
  for (const Words& threads :
       {Words{"--executor", "serial", "--threads", "1"}, Words{"--executor", "threads", "--threads", "3"}}) {
    Words arguments = GetParam();
    arguments.insert(arguments.end(), work.begin(), work.end());
    const json run = done(arguments, threads);
    EXPECT_GT(run.at("work").at("frames_with_pairs_left"), 0) << "the view decides";
    hashes.insert(run.at("state_hash").dump());
  }
  EXPECT_EQ(hashes.size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(OfTheCommand, ShippedScenes, ::testing::Values(kPour, kMetropolis, kStreet),
                         [](const ::testing::TestParamInfo<Words>& info) { return info.param.front(); });

TEST(Street, IsRefinedByItsGaze) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("gaze.csv")) << "0,640,360\n";
  const Words work{"--clock", "work", "--budget-work", "200"};
  const json jumping = done(kStreet, work);
  Words arguments = kStreet;
  arguments.insert(arguments.end(), {"--gaze", folder.file("gaze.csv")});
  EXPECT_NE(done(arguments, work).at("state_hash"), jumping.at("state_hash")) << "other pairs were refined first";
}

TEST(Pour, FillsItsTrayAndEmptiesItAgain) {
  const TemporaryFolder folder;
  const json run = done({"pour", "--bodies", "120"}, {"--clock", "work", "--states", folder.file("states.csv")});
  EXPECT_EQ(run.at("frames"), 900);
  EXPECT_EQ(run.at("bodies"), 5) << "the tray";
  EXPECT_EQ(run.at("dynamic_bodies"), 0);
  EXPECT_NEAR(run.at("dynamic_bodies_max").get<int>(), 90, 1) << "those of six seconds";
  const std::string states = contents(folder.file("states.csv"));
  EXPECT_EQ(column_of(states, 0), "0 1 2 3 4 ");
  EXPECT_EQ(column_of(states, 5), "0 1 2 3 4 5 6 ");
  EXPECT_EQ(column_of(states, 830), "0 1 2 3 4 123 124 ");
  EXPECT_EQ(column_of(states, 900), "0 1 2 3 4 ");
}

TEST(Pour, ExplainsAFrameByTheNumbersOfItsStates) {
  const TemporaryFolder folder;
  const std::string file = folder.file("run.poise");
  Words arguments = kPour;
  arguments.insert(arguments.end(), {"--record", file, "--states", folder.file("states.csv")});
  done(arguments, {"--clock", "work", "--budget-work", "20"});
  const json explain = done({"replay", file}, {"--explain", "590"}).at("explain");
  const std::string there = " " + column_of(contents(folder.file("states.csv")), 591);
  EXPECT_EQ(there.find(" 7 "), std::string::npos) << "it has left, and its slot is in use again";
  ASSERT_GT(explain.at("refined").size(), 0U);
  for (const char* list : {"refined", "left_coarse"}) {
    for (const json& row : explain.at(list)) {
      for (const char* side : {"a", "b"})
        EXPECT_NE(there.find(" " + row.at(side).dump() + " "), std::string::npos) << row.at(side);
    }
  }
}

TEST(Metropolis, IsRefinedAndDrawnFromWhereTheCameraIs) {
  const TemporaryFolder folder;
  std::string text = contents(POISE_SOURCE_DIR "/scenes/metropolis.json");
  const std::size_t path = text.find("\"path\": [");
  const std::size_t end = text.find("],\n    \"up\"", path);
  ASSERT_NE(end, std::string::npos);
  text.replace(path, end + 1 - path, R"("position_m": [-12, 5.5, 1.7], "look_at_m": [0, 4, 2])");
  std::ofstream(folder.file("standing.json")) << text;
  const auto run = [&folder](const std::string& scene, const char* frames) {
    Words arguments = kMetropolis;
    arguments.front() = scene;
    arguments.back() = frames;
    const json report = done(arguments, {"--clock", "work", "--budget-work", "20", "--picture", folder.file("p.png")});
    return std::pair(report.at("state_hash"), contents(folder.file("p.png")));
  };
  const auto walking = run("metropolis", "200");
  const auto standing = run(folder.file("standing.json"), "200");
  EXPECT_NE(walking.first, standing.first) << "other pairs were refined first";
  EXPECT_NE(walking.second, standing.second);
  EXPECT_EQ(run("metropolis", "1"), run(folder.file("standing.json"), "1")) << "the first key";
}

}  // namespace
}  // namespace poise::testing
