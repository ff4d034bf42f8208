// SPDX-License-Identifier: MIT
#include "studies/study_strips.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "app/command.h"
#include "scene/scene_text.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

// Two balls of half a metre that meet head on at 0.5 s.
Result<app::Strips> two_balls(const std::string& more_bodies = "") {
  const Result<Scene> scene =
      parse(scene_text(R"("frames": 80, "camera": {"position_m": [0, -8, 0], "look_at_m": [0, 0, 0]}, )",
                       R"([{"shape": "floor", "material": "hard", "static": true, "position_m": [0, 0, -9]},
          {"shape": "ball", "material": "hard", "position_m": [-1, 0, 0], "velocity_mps": [1, 0, 0]},
          {"shape": "ball", "material": "hard", "position_m": [1, 0, 0], "velocity_mps": [-1, 0, 0]})" +
                           more_bodies + "]"));
  EXPECT_TRUE(scene) << scene.error().message;
  SceneRunOptions start;
  start.world.threads = 1;
  return app::collide(scene.value(), start);
}

TEST(StudyStrips, OfTwoBallsTellsTheTimeTheGapAndTheVelocitiesOfClosedForm) {
  const Result<app::Strips> strips = two_balls();
  ASSERT_TRUE(strips) << strips.error().message;
  EXPECT_EQ(strips.value().bodies, (std::array<std::uint64_t, 2>{1, 2}));
  ASSERT_EQ(strips.value().strips.size(), 1U) << "a ball is its own tree, and has no polygons";
  const app::Strip& strip = strips.value().strips[0];
  ASSERT_TRUE(strip.met);
  EXPECT_EQ(strip.balls, 2U);
  // They close at 2 m/s from a gap of 1 m, in steps of 0.01 s; the answer comes in the step in which they meet.
  EXPECT_NEAR(strip.time_s, 0.5, 0.0101);
  EXPECT_NEAR(strip.gap_m, 1 - 2 * strip.time_s, 1e-6);
  EXPECT_NEAR(strip.gap_radii, strip.gap_m / 0.5, 1e-9);
  EXPECT_NEAR(strip.velocity_mps[0].x(), -0.5, 1e-6) << "restitution 0.5";
  EXPECT_NEAR(strip.velocity_mps[1].x(), 0.5, 1e-6);
  ASSERT_EQ(strip.moments.size(), 4U);
  EXPECT_EQ(strip.moments[0].frame, 0U);
  EXPECT_NEAR(strip.moments[1].time_s, strip.time_s, 1e-12);
  EXPECT_LT(strip.moments[1].frame, strip.moments[2].frame);
  EXPECT_EQ(strip.moments[3].frame, 80U);
}

TEST(StudyStrips, OfBodiesOnAFloorWaitsForTheirOwnCollision) {
  // They slide from the first frame on, at 2 m/s from a gap of 1 m.
  const Result<Scene> scene = parse(scene_text(R"("frames": 80, "gravity_mps2": [0, 0, -10], )",
                                               R"([{"shape": "floor", "material": "hard", "static": true},
          {"shape": "ball", "material": "hard", "position_m": [-1, 0, 0.5], "velocity_mps": [1, 0, 0]},
          {"shape": "ball", "material": "hard", "position_m": [1, 0, 0.5], "velocity_mps": [-1, 0, 0]}])"));
  ASSERT_TRUE(scene) << scene.error().message;
  const Result<app::Strips> strips = app::collide(scene.value(), {});
  ASSERT_TRUE(strips) << strips.error().message;
  ASSERT_TRUE(strips.value().strips[0].met);
  EXPECT_GT(strips.value().strips[0].time_s, 0.4) << "friction slows them";
  EXPECT_LT(strips.value().strips[0].gap_m, 0.021);
}

TEST(StudyStrips, OfBodiesThatNeverMeetSaysSo) {
  const Result<Scene> scene = parse(scene_text(R"("frames": 5, )", R"([{"shape": "ball", "material": "hard"},
      {"shape": "ball", "material": "hard", "position_m": [5, 0, 0]}])"));
  ASSERT_TRUE(scene) << scene.error().message;
  const Result<app::Strips> strips = app::collide(scene.value(), {});
  ASSERT_TRUE(strips) << strips.error().message;
  EXPECT_FALSE(strips.value().strips[0].met);
  EXPECT_EQ(strips.value().strips[0].moments.size(), 4U);
  const app::StudyStripsOptions options;
  const io::StudyTable table = app::strips_table(strips.value(), options);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(table.rows[0][2])) << "no time of a collision";
}

TEST(StudyStrips, RefusesAnyOtherNumberOfBodiesThanTwo) {
  const Result<app::Strips> three = two_balls(R"(, {"shape": "ball", "material": "hard", "position_m": [9, 9, 9]})");
  ASSERT_FALSE(three);
  EXPECT_EQ(three.error().message, "--scene: it has 3 dynamic bodies, must have two that meet");
}

TEST(StudyStrips, OfTwoJacksHasARowALevelWithSmallerGapsAndDrawsThem) {
  const TemporaryFolder folder;
  const CommandResult result = poise_command({"study", "strips", "--quiet", "--json", "-", "--picture",
                                              folder.file("strips.png"), "--svg", folder.file("strips.svg")});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json study = json::parse(result.out, nullptr, false);
  EXPECT_EQ(study.at("schema"), "poise.strips/1");
  EXPECT_EQ(study.at("contact"), "fitted");
  const json& rows = study.at("rows");
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_EQ(rows[0].at("level"), "0");
  EXPECT_EQ(rows[0].at("balls"), 2);
  EXPECT_EQ(rows[3].at("level"), "polygons");
  EXPECT_TRUE(rows[3].at("balls").is_null());
  EXPECT_GT(rows[0].at("gap_mm"), 3 * rows[1].at("gap_mm").get<double>());
  EXPECT_GT(rows[1].at("gap_mm"), 3 * rows[3].at("gap_mm").get<double>());
  EXPECT_LT(rows[3].at("gap_mm"), 4.01) << "what they close in a step of 1 ms";
  EXPECT_LT(rows[0].at("late_ms"), -10) << "balls are answered before the surfaces meet";
  EXPECT_EQ(rows[3].at("error_mps"), 0);
  for (const json& row : rows)
    EXPECT_NEAR(row.at("left_vx_mps").get<double>(), -row.at("right_vx_mps").get<double>(), 1e-9) << "momentum";
  EXPECT_EQ(contents(folder.file("strips.png")).substr(1, 3), "PNG");
  const std::string svg = contents(folder.file("strips.svg"));
  EXPECT_TRUE(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
  EXPECT_NE(svg.find(">level 0, 2 balls: answered at "), std::string::npos);
  // Of 2,112 triangles in each of 16 panels about half face the viewer.
  std::size_t triangles = 0;
  for (std::size_t at = svg.find("z\" color="); at != std::string::npos; at = svg.find("z\" color=", at + 1))
    ++triangles;
  EXPECT_NEAR(static_cast<double>(triangles), 16 * 1056, 16 * 300);
}

TEST(StudyStrips, AsAnSvgHasFourPanelsALevelWithBodiesBallsAndArrows) {
  const Result<app::Strips> strips = two_balls();
  ASSERT_TRUE(strips) << strips.error().message;
  const std::string svg = app::strips_svg(strips.value());
  const auto count = [&](const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = svg.find(part); at != std::string::npos; at = svg.find(part, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count("<svg "), 1U + 4U);
  EXPECT_EQ(count("<circle "), 2U * 4U + 2U) << "two balls in each panel, and those of the level at the collision";
  EXPECT_EQ(count("style=\"stroke: #d55e00\""), 2U) << "an arrow each at the end";
  // They begin left and right of the middle of the picture, 320 x 190 pixels.
  const std::size_t first = svg.find("cx=\""), second = svg.find("cx=\"", first + 1);
  EXPECT_NEAR(std::stod(svg.substr(first + 4)) + std::stod(svg.substr(second + 4)), 320, 0.3);
  EXPECT_EQ(std::stod(svg.substr(svg.find("cy=\"") + 4)), 95);
}

TEST(StudyStrips, RefusesWrongOptions) {
  const auto refused = [](std::vector<std::string> arguments, int code, const std::string& message) {
    arguments.insert(arguments.begin(), {"study", "strips"});
    const CommandResult result = poise_command(arguments);
    EXPECT_EQ(result.exit_code, code) << message;
    EXPECT_NE(result.error.find(message), std::string::npos) << result.error;
  };
  refused({"--contact", "magic"}, 2, "--contact");
  refused({"--picture", "a.svg"}, 2, "the ending must be .png");
  refused({"--json", "-", "--markdown", "-"}, 2, "only one of --json and --markdown");
  refused({"--scene", "no-such-scene"}, 3, "no scene of this name ships");
  refused({"--scene", "pile"}, 3, "dynamic bodies, must have two that meet");
  refused({"--json", "/no/such/folder/a.json"}, 4, "No such file or directory");
}

}  // namespace
}  // namespace poise::testing
