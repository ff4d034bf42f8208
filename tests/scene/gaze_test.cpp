// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <string>
#include <utility>

#include "scene/scene_gaze.h"
#include "scene/scene_text.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

const std::string kCamera =
    R"("camera": {"position_m": [0, 0, 0], "look_at_m": [1, 0, 0], "vertical_fov_deg": 90, "resolution_px": [200, 100]}, )";
using Point = std::array<double, 2>;

std::string with_gaze(const std::string& members) { return scene_text(kCamera + "\"gaze\": {" + members + "}, "); }

Point gaze_of(const Scene& scene, double time_s) { return io::gaze_at(scene, time_s).value(); }

const std::string kPath =
    R"("path": [{"time_s": 1, "at_px": [0, 0]}, {"time_s": 2, "at_px": [200, 100]}, {"time_s": 4, "at_px": [100, 100]}])";

TEST(Gaze, MovesStraightFromKeyToKey) {
  const Scene scene = parse(with_gaze(kPath)).value();
  const std::pair<double, Point> points[] = {{0, {0, 0}},     {1, {0, 0}},     {1.5, {100, 50}},
                                             {2, {200, 100}}, {3, {150, 100}}, {9, {100, 100}}};
  for (const auto& [time_s, at_px] : points) EXPECT_EQ(gaze_of(scene, time_s), at_px) << time_s;
}

TEST(Gaze, ThatJumpsStaysUntilTheNextKey) {
  const Scene scene = parse(with_gaze(kPath + R"(, "jumps": true)")).value();
  EXPECT_EQ(gaze_of(scene, 1.999), (Point{0, 0}));
  EXPECT_EQ(gaze_of(scene, 2), (Point{200, 100}));
  EXPECT_EQ(gaze_of(scene, 3.9), (Point{200, 100}));
}

TEST(Gaze, OfALoopBeginsAgain) {
  const Scene scene = parse(with_gaze(kPath + R"(, "loop": true)")).value();
  EXPECT_EQ(gaze_of(scene, 4), (Point{100, 100}));
  EXPECT_EQ(gaze_of(scene, 4.5), gaze_of(scene, 1.5));
  EXPECT_EQ(gaze_of(scene, 3000.5 + 1), gaze_of(scene, 1.5));
}

TEST(Gaze, TurnsTheViewAndNotTheCamera) {
  const Scene scene = parse(with_gaze(kPath)).value();
  const View before = scene_view(scene, 1);
  const View after = scene_view(scene, 2);
  EXPECT_EQ(before.forward, after.forward);
  EXPECT_GT((before.gaze - after.gaze).norm(), 0.5);
  EXPECT_NEAR((before.gaze - Vec3(1, 2, 1).normalized()).norm(), 0, 1e-12) << "the upper left corner";
}

TEST(Gaze, OfARunIsThatOfItsFrame) {
  Result<SceneRun> run = SceneRun::create(parse(with_gaze(kPath)).value(), {});
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_TRUE(run.value().before_frame(0));
  const Vec3 first = run.value().view().gaze;
  EXPECT_TRUE(run.value().before_frame(200));
  EXPECT_GT((run.value().view().gaze - first).norm(), 0.5);
}

TEST(Gaze, OfAFileIsReadWhenTheRunIsMade) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("gaze.csv")) << "\xef\xbb\xbftime_s,x_px,y_px\r\n0,100,50\r\n\r\n1.5, 200 ,0\n";
  const auto scene = [&](const std::string& file) {
    return parse_scene(with_gaze("\"file\": \"" + file + "\""), "s.json", folder.path()).value();
  };
  Result<SceneRun> run = SceneRun::create(scene("gaze.csv"), {});
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_NEAR((run.value().view().gaze - Vec3::UnitX()).norm(), 0, 1e-12);
  EXPECT_TRUE(run.value().before_frame(149));
  EXPECT_NEAR((run.value().view().gaze - Vec3::UnitX()).norm(), 0, 1e-12) << "it stays";
  EXPECT_TRUE(run.value().before_frame(150));
  EXPECT_NEAR((run.value().view().gaze - Vec3(1, -2, 1).normalized()).norm(), 0, 1e-12);
  const Result<SceneRun> missing = SceneRun::create(scene("none.csv"), {});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().message,
            "s.json: gaze.file: " + folder.file("none.csv") + ": cannot be read: no such file");
}

TEST(Gaze, OfASceneIsRefusedWithItsField) {
  const std::pair<std::string, std::string> cases[] = {
      {scene_text(R"("gaze": {"file": "g.csv"}, )"), "gaze: needs a camera"},
      {with_gaze(""), "gaze: must have exactly one of path, file"},
      {with_gaze(kPath + R"(, "file": "g.csv")"), "gaze: must have exactly one of path, file"},
      {with_gaze(R"("path": [])"), "gaze.path = [], must be a list of at least one key"},
      {with_gaze(R"("path": [{"time_s": -1, "at_px": [0, 0]}])"), "gaze.path[0].time_s = -1, must be >= 0"},
      {with_gaze(R"("path": [{"time_s": 0}])"), "gaze.path[0].at_px: missing, and it is required"},
      {with_gaze(R"("path": [{"time_s": 0, "at_px": [0, 0]}, {"time_s": 0, "at_px": [0, 0]}])"),
       "gaze.path[1].time_s = 0, must be > that of the key before"},
      {with_gaze(R"("path": [{"time_s": 0, "at_px": [201, 0]}])"),
       "gaze.path[0].at_px = [201, 0], must lie in the image of 200 x 100 pixels"},
      {with_gaze(R"("file": "")"), "gaze.file = \"\", must be the name of a file"},
      {with_gaze(R"("file": "g.csv", "jumps": true)"), "gaze.jumps: not with file, whose points stay until the next"},
      {with_gaze(R"("pth": 1)"), "gaze.pth: no such field; did you mean \"path\"?"},
      {scene_text(kCamera + R"("gaze_px": [1, 1], "gaze": {"file": "g.csv"}, )"),
       "gaze_px: not with gaze, which says where the viewer looks"}};
  for (const auto& [text, message] : cases) {
    EXPECT_NE(refusal(text).find("s.json: " + message), std::string::npos) << refusal(text);
  }
}

TEST(Gaze, OfAFileIsRefusedWithLineFieldValueAndRule) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "g.csv: has no points, must have at least one line of time_s,x_px,y_px"},
      {"time_s,x_px,y_px\n", "g.csv: has no points, must have at least one line of time_s,x_px,y_px"},
      {"0,1\n", "g.csv: line 1: has 2 fields, must have 3: time_s,x_px,y_px"},
      {"0,1,2,3\n", "g.csv: line 1: has 4 fields, must have 3: time_s,x_px,y_px"},
      {"t,x,y\n0,1,2\n", "g.csv: line 1: time_s = t, must be a number"},
      {"0,1,2\n1,nan,2\n", "g.csv: line 2: x_px = nan, must be a number"},
      {"0,1,2\n1,1e999,2\n", "g.csv: line 2: x_px = 1e999, must be a number"},
      {"0,1,2\n1,,2\n", "g.csv: line 2: x_px = , must be a number"},
      {"0,1,2\n1,200.5,2\n", "g.csv: line 2: x_px = 200.5, must be 0 to 200"},
      {"0,1,2\n\n1,1,-3\n", "g.csv: line 3: y_px = -3, must be 0 to 100"},
      {"-1,1,2\n", "g.csv: line 1: time_s = -1, must be 0 to 1e+09"},
      {"0,1,2\n0,1,2\n", "g.csv: line 2: time_s = 0, must be > 0, that of the point before"}};
  for (const auto& [text, message] : cases) {
    const Result<std::vector<GazeKey>> read = parse_gaze(text, "g.csv", {200, 100});
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().message, message);
  }
  const Result<std::vector<GazeKey>> read = parse_gaze("time,x,y\n0,1,2\n", "g.csv", {200, 100});
  ASSERT_TRUE(read);
  EXPECT_EQ(read.value().size(), 1U);
}

}  // namespace
}  // namespace poise::testing
