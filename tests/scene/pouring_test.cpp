// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "poise/scene/scene.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

std::string with(const std::string& members) {
  return R"({"name": "s", "dt_s": 0.01, "gravity_mps2": [0, 0, -9.81], "materials": {"wood": {}},
    "shapes": {"ball": {"sphere": {"radius_m": 0.5}}, "cup": {"sphere": {"radius_m": 0.25}},
               "floor": {"plane": {"normal": [0, 0, 1], "offset_m": 0}},
               "lid": {"plane": {"normal": [0, 0, -1], "offset_m": -4}}}, )" +
         members + "}";
}
const char* const kGrid =
    R"("generators": [{"grid": {"shapes": ["ball", "cup"], "material": "wood", "count": [3, 3, 1], "spacing_m": 2,
                               "origin_m": [0, 0, 1]}}])";

SceneRun start(const std::string& text) {
  const Result<Scene> scene = parse_scene(text, "s.json", {});
  EXPECT_TRUE(scene.ok()) << (scene ? "" : scene.error().message);
  SceneRunOptions options;
  options.world.executor = ExecutorKind::Serial;
  Result<SceneRun> run = SceneRun::create(scene.value(), options);
  EXPECT_TRUE(run.ok()) << (run ? "" : run.error().message);
  return std::move(run).value();
}

Vec3 place(const SceneRun& run, std::size_t i) { return run.world().state(run.bodies()[i].id).value().position_m; }
double radius(const SceneRun& run, std::size_t i) { return run.shapes()[run.bodies()[i].shape]->bounding_radius_m; }

TEST(Pouring, DropsBodiesOfTheGeneratorsKindsFromAboveWithoutOverlap) {
  SceneRun run = start(with(kGrid));
  const std::size_t before = run.bodies().size();
  std::uint64_t poured = 0;
  for (int again = 0; again < 20 && poured < 30; ++again) poured += run.pour(30 - poured).value();
  ASSERT_EQ(poured, 30U);
  ASSERT_EQ(run.bodies().size(), before + 30);
  bool balls = false, cups = false;
  for (std::size_t i = before; i < run.bodies().size(); ++i) {
    const Vec3 center = place(run, i);
    EXPECT_GE(center.x(), 0);
    EXPECT_LE(center.x(), 4);
    EXPECT_GT(center.z(), 1);
    EXPECT_EQ(run.bodies()[i].number, i);
    (run.bodies()[i].shape == 0 ? balls : cups) = true;
    for (std::size_t other = 0; other < i; ++other)
      EXPECT_GT((place(run, other) - center).norm(), radius(run, other) + radius(run, i));
  }
  EXPECT_TRUE(balls && cups);
}

TEST(Pouring, FindsFreePlacesWhereThereIsNoGravityOrALid) {
  std::string free = with(kGrid);
  free.replace(free.find("-9.81"), 5, "0");
  const std::string lid = with(std::string(R"("bodies": [{"shape": "lid", "material": "wood", "static": true}], )") +
                               R"("generators": [{"stream": {"shape": "cup", "material": "wood", "total": 1,
                                 "from_s": 5, "per_second": 1, "region_min_m": [0, 0, 1], "region_max_m": [4, 4, 3]}}])");
  for (const std::string& text : {free, lid}) {
    SceneRun run = start(text);
    const std::size_t before = run.bodies().size();
    const Result<std::uint64_t> poured = run.pour(5);
    ASSERT_TRUE(poured.ok());
    for (std::size_t i = before; i < run.bodies().size(); ++i) EXPECT_LE(place(run, i).z(), 3);
    EXPECT_EQ(poured.value(), run.bodies().size() - before);
    if (text == lid) {
      EXPECT_EQ(poured.value(), 5U);
    }
  }
}

TEST(Pouring, UsesTheBodiesOfTheListWhereThereAreNoGenerators) {
  SceneRun run = start(with(R"("bodies": [{"shape": "floor", "material": "wood", "static": true},
                                          {"shape": "ball", "material": "wood", "position_m": [0, 0, 1]}])"));
  EXPECT_EQ(run.pour(1).value(), 1U);
  EXPECT_EQ(run.bodies().back().shape, 0U);
  EXPECT_GT(place(run, 2).z(), 2);
}

TEST(Pouring, FindsPlacesAroundASingleBodyWithoutGravity) {
  std::string text = with(R"("bodies": [{"shape": "ball", "material": "wood", "position_m": [0, 0, 1]}])");
  text.replace(text.find("-9.81"), 5, "0");
  SceneRun run = start(text);
  std::uint64_t poured = 0;
  for (int again = 0; again < 20 && poured < 20; ++again) poured += run.pour(20 - poured).value();
  EXPECT_EQ(poured, 20U);
}

TEST(Pouring, IsRefusedWhereNothingMoves) {
  SceneRun run = start(with(R"("bodies": [{"shape": "floor", "material": "wood", "static": true}])"));
  const Result<std::uint64_t> poured = run.pour(1);
  ASSERT_FALSE(poured.ok());
  EXPECT_EQ(poured.error().message, "s.json: has no dynamic bodies, so there is nothing to pour");
}

TEST(Pouring, TheLastAreRemovedFirstAndStaticOnesStay) {
  SceneRun run = start(with(std::string(kGrid) + R"(, "tray": {"material": "wood", "side_m": 9})"));
  ASSERT_EQ(run.pour(2).value(), 2U);
  EXPECT_EQ(run.remove_last(3).value(), 3U);
  EXPECT_EQ(run.bodies().size(), 5U + 8U);
  EXPECT_EQ(run.bodies().back().number, 5U + 7U);
  EXPECT_EQ(run.remove_last(100).value(), 8U);
  EXPECT_EQ(run.bodies().size(), 5U);
  // A number is not given again.
  ASSERT_EQ(run.pour(1).value(), 1U);
  EXPECT_EQ(run.bodies().back().number, 5U + 9U + 2U);
  ASSERT_TRUE(run.before_frame(0).ok());
}

TEST(SceneRunAgain, IsTheSameRunFromItsStart) {
  SceneRun run = start(with(std::string(kGrid) + R"(, "tray": {"material": "wood", "side_m": 9})"));
  const std::uint64_t at_start = run.world().state_hash();
  ASSERT_EQ(run.pour(3).value(), 3U);
  SceneRunOptions options;
  options.world.executor = ExecutorKind::Serial;
  const Result<SceneRun> again = run.again(options);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again.value().world().state_hash(), at_start);
  EXPECT_EQ(again.value().shapes()[0], run.shapes()[0]);
}

}  // namespace
}  // namespace poise::testing
