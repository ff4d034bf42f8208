// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "scene/scene_text.h"

namespace poise::testing {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kStepS = 1e-6;

Scene with_camera(const std::string& members) {
  const Result<Scene> scene = parse(scene_text("\"camera\": {" + members + "}, "));
  EXPECT_TRUE(scene) << scene.error().message;
  return scene.value();
}

/// Four keys at unequal times; looks along +y all the time.
Scene walk(const std::string& more = "") {
  return with_camera(R"("vertical_fov_deg": 40, "path": [
      {"time_s": 1, "position_m": [0, 0, 1], "look_at_m": [0, 10, 1]},
      {"time_s": 2, "position_m": [4, 0, 1], "look_at_m": [4, 10, 1]},
      {"time_s": 4, "position_m": [12, 0, 1], "look_at_m": [12, 10, 1], "vertical_fov_deg": 60},
      {"time_s": 5, "position_m": [12, 4, 3], "look_at_m": [12, 14, 3]}])" +
                     more);
}

/// A square in which the camera goes round and looks ahead.
Scene round_walk() {
  return with_camera(R"("loop": true, "path": [
      {"time_s": 1, "position_m": [0, 0, 1], "look_at_m": [9, 0, 1]},
      {"time_s": 2, "position_m": [5, 0, 1], "look_at_m": [5, 9, 1]},
      {"time_s": 4, "position_m": [5, 5, 1], "look_at_m": [-9, 5, 1]},
      {"time_s": 5, "position_m": [0, 5, 1], "look_at_m": [0, -9, 1]},
      {"time_s": 7, "position_m": [0, 0, 1], "look_at_m": [9, 0, 1]}])");
}

void expect_same(const View& a, const View& b, double tolerance) {
  EXPECT_NEAR((a.position_m - b.position_m).norm(), 0, tolerance);
  EXPECT_NEAR((a.forward - b.forward).norm(), 0, tolerance);
  EXPECT_NEAR((a.up - b.up).norm(), 0, tolerance);
  EXPECT_NEAR(a.vertical_fov_rad, b.vertical_fov_rad, tolerance);
}

TEST(CameraPath, PassesItsKeysAndStaysBeforeTheFirstAndAfterTheLast) {
  const Scene scene = walk();
  const std::pair<double, Vec3> places[] = {{0, {0, 0, 1}},  {1, {0, 0, 1}},  {2, {4, 0, 1}},
                                            {4, {12, 0, 1}}, {5, {12, 4, 3}}, {1e6, {12, 4, 3}}};
  for (const auto& [time_s, position_m] : places) {
    const View view = scene_view(scene, time_s);
    EXPECT_NEAR((view.position_m - position_m).norm(), 0, 1e-14) << time_s;
    EXPECT_NEAR((view.forward - Vec3::UnitY()).norm(), 0, 1e-14) << time_s;
    EXPECT_NEAR((view.up - Vec3::UnitZ()).norm(), 0, 1e-14) << time_s;
  }
  EXPECT_EQ(scene.camera->position_m, Vec3(0, 0, 1));
  EXPECT_EQ(scene.camera->look_at_m, Vec3(0, 10, 1));
}

TEST(CameraPath, ChangesTheFieldOfViewLinearlyAndTakesThatOfTheCameraWhereAKeyHasNone) {
  const Scene scene = walk();
  for (const auto& [time_s, fov_deg] : {std::pair(1.5, 40.0), {2.0, 40.0}, {3.0, 50.0}, {4.0, 60.0}, {4.5, 50.0}})
    EXPECT_NEAR(scene_view(scene, time_s).vertical_fov_rad, fov_deg * kDegree, 1e-14) << time_s;
}

TEST(CameraPath, KeepsItsVelocityAtKeysAndBeginsAndEndsAtRest) {
  for (const Scene& scene : {walk(), round_walk()}) {
    const auto velocity_mps = [&scene](double time_s) {
      return Vec3((scene_view(scene, time_s + kStepS).position_m - scene_view(scene, time_s).position_m) / kStepS);
    };
    for (const double time_s : {1.0, 2.0, 4.0, 5.0}) {
      if (scene.camera->loop && time_s == 1) continue;  // it stands still until the first key
      EXPECT_NEAR((velocity_mps(time_s) - velocity_mps(time_s - kStepS)).norm(), 0, 1e-4) << time_s;
    }
  }
  // (12 - 0) m in (4 - 1) s.
  const Scene scene = walk();
  EXPECT_NEAR((scene_view(scene, 2 + 1e-6).position_m.x() - 4) / 1e-6, 4, 1e-4);
  EXPECT_NEAR((scene_view(scene, 1 + 1e-6).position_m.x() - 0) / 1e-6, 0, 1e-4);
}

TEST(CameraPath, OfALoopBeginsAgainWithoutAJump) {
  const Scene scene = round_walk();
  for (const double time_s : {1.25, 2.0, 3.5, 6.0}) {
    expect_same(scene_view(scene, time_s + 6), scene_view(scene, time_s), 1e-12);
    expect_same(scene_view(scene, time_s + 600), scene_view(scene, time_s), 1e-10);
  }
  EXPECT_EQ(scene_view(scene, 0).position_m, Vec3(0, 0, 1));
  const Vec3 before = scene_view(scene, 7).position_m - scene_view(scene, 7 - 1e-6).position_m;
  const Vec3 after = scene_view(scene, 7 + 1e-6).position_m - scene_view(scene, 7).position_m;
  EXPECT_NEAR((after - before).norm() / 1e-6, 0, 1e-4) << "nor in its velocity";
  EXPECT_GT(after.norm() / 1e-6, 1);
}

TEST(CameraPath, LooksWhereTheKeyBeforeDidWhileItsOwnLineOfSightHasNoDirection) {
  // In the middle the point looked at is the place of the camera, and a quarter of the way later it is above it.
  const Scene turn = with_camera(R"("path": [
      {"time_s": 0, "position_m": [0, 0, 0], "look_at_m": [2, 0, 0]},
      {"time_s": 1, "position_m": [0, 0, 0], "look_at_m": [-2, 0, 0]}])");
  EXPECT_EQ(scene_view(turn, 0.5).forward, Vec3::UnitX());
  EXPECT_EQ(scene_view(turn, 0.75).forward, -Vec3::UnitX());
  const Scene over = with_camera(R"("path": [
      {"time_s": 0, "position_m": [0, 0, 0], "look_at_m": [2, 0, 1]},
      {"time_s": 1, "position_m": [0, 0, 0], "look_at_m": [-2, 0, 1]}])");
  const View view = scene_view(over, 0.5);
  EXPECT_NEAR((view.forward - Vec3(2, 0, 1).normalized()).norm(), 0, 1e-14);
  EXPECT_TRUE(view.up.allFinite());
}

TEST(CameraPath, IsNotNeeded) {
  const Scene scene = with_camera(R"("position_m": [1, 2, 3], "look_at_m": [4, 4, 4])");
  const View start = scene_view(scene);
  const View later = scene_view(scene, 17.3);
  EXPECT_EQ(start.position_m, later.position_m);
  EXPECT_EQ(start.forward, later.forward);
  EXPECT_EQ(start.up, later.up);
}

TEST(CameraPath, IsFollowedByTheViewOfARunFromFrameToFrame) {
  const Scene scene = walk();
  SceneRunOptions options;
  options.world.threads = 1;
  Result<SceneRun> run = SceneRun::create(scene, options);
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_EQ(run.value().view().position_m, Vec3(0, 0, 1));
  for (const std::uint64_t frame : {0U, 137U, 200U, 333U, 600U}) {
    ASSERT_TRUE(run.value().before_frame(frame));
    const View expected = scene_view(scene, static_cast<double>(frame) * 0.01);
    EXPECT_EQ(run.value().view().position_m, expected.position_m);
    EXPECT_EQ(run.value().view().forward, expected.forward);
    EXPECT_EQ(run.value().view().vertical_fov_rad, expected.vertical_fov_rad);
  }
}

}  // namespace
}  // namespace poise::testing
