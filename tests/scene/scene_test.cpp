// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "scene/scene_text.h"

namespace poise::testing {
namespace {

TEST(Scene, HasTheStatedDefaults) {
  const Result<Scene> read = parse(scene_text(""));
  ASSERT_TRUE(read) << read.error().message;
  const Scene& scene = read.value();
  EXPECT_EQ(scene.gravity_mps2, Vec3::Zero());
  EXPECT_EQ(scene.frames, 600U);
  EXPECT_EQ(scene.seed, 1U);
  EXPECT_FALSE(scene.deadline_ms);
  EXPECT_FALSE(scene.camera);
  EXPECT_FALSE(scene_view(scene).present);
  EXPECT_EQ(scene.materials[0].material.density_kgpm3, 1000);
  EXPECT_EQ(scene.materials[0].material.friction, 0);
  const BodyDefinition& body = scene.bodies.at(0).definition;
  EXPECT_EQ(body.orientation.coeffs(), Quat::Identity().coeffs());
  EXPECT_EQ(body.mass_kg, 0);
  EXPECT_EQ(body.velocity_mps, Vec3::Zero());
  EXPECT_EQ(body.motion, MotionType::Dynamic);
  EXPECT_EQ(scene.policy.kind, scheduler::PolicyKind::Perceptual);
  EXPECT_EQ(scene.max_level, kMaxTreeDepth);
  EXPECT_FALSE(scene.polygons);
  EXPECT_FALSE(scene.sleeping);
  EXPECT_TRUE(parse(scene_text(R"("sleeping": true, )")).value().sleeping);
}

TEST(Scene, NamesTheDeepestLevelOrPolygons) {
  const Scene level = parse(scene_text(R"("max_level": 2, )")).value();
  EXPECT_EQ(level.max_level, 2);
  EXPECT_FALSE(level.polygons);
  const Scene polygons = parse(scene_text(R"("max_level": "polygons", )")).value();
  EXPECT_EQ(polygons.max_level, kMaxTreeDepth);
  EXPECT_TRUE(polygons.polygons);
}

TEST(Scene, TakesTheFormOfTheDocumentation) {
  const Result<Scene> read = parse(R"({
    "name": "two balls and a cow", // a comment
    "gravity_mps2": [0, 0, -9.81], "dt_s": 0.016666666666666666, "frames": 600, "seed": 1, "deadline_ms": 16.0,
    "camera": {"position_m": [8, -8, 5], "look_at_m": [0, 0, 1], "up": [0, 0, 1], "vertical_fov_deg": 50, "resolution_px": [1280, 720]},
    "gaze_px": [640, 360],
    "materials": {"hard": {"restitution": 0.7, "friction": 0.0, "density_kgpm3": 1000}},
    "shapes": {
      "ball":  {"sphere": {"radius_m": 0.5}},
      "cow":   {"mesh": {"file": "meshes/cow.obj", "scale": 1.0, "depth": 3}},
      "floor": {"plane": {"normal": [0, 0, 1], "offset_m": 0}}
    },
    "bodies": [
      {"shape": "floor", "material": "hard", "static": true},
      {"shape": "ball", "material": "hard", "position_m": [0, 0, 2], "orientation_wxyz": [2, 0, 0, 0],
       "velocity_mps": [1, 0, 0], "angular_velocity_radps": [0, 0, 3], "mass_kg": 2.0, "inertia_kgm2": [0.2, 0.2, 0.2]}
    ],
    /* and a
       long one */
    "generators": [{"grid": {"shape": "cow", "material": "hard", "count": [10, 10, 5], "spacing_m": 1.2, "origin_m": [-5, -5, 1],
                    "jitter_m": 0.05, "random_orientation": true, "seed": 7}}]
  })");
  ASSERT_TRUE(read) << read.error().message;
  const Scene& scene = read.value();
  EXPECT_EQ(scene.shapes[1].name, "cow");
  EXPECT_EQ(std::get<MeshSource>(scene.shapes[1].source).file, "meshes/cow.obj");
  EXPECT_EQ(scene.bodies[1].shape, 0U);
  EXPECT_EQ(scene.bodies[1].definition.orientation.w(), 1);
  EXPECT_EQ(scene.bodies[1].definition.inertia_kgm2, Vec3(0.2, 0.2, 0.2));
  EXPECT_EQ(generated_body_count(scene), 500U);
  const View view = scene_view(scene);
  ASSERT_TRUE(view.present);
  EXPECT_NEAR((view.gaze - view.forward).norm(), 0, 1e-15);
  EXPECT_NEAR(view.up.dot(view.forward), 0, 1e-15);
  EXPECT_NEAR(view.aspect, 16.0 / 9, 1e-15);
}

TEST(Scene, TurnsTheGazeByTheAngleOfThePixel) {
  const Result<Scene> read = parse(scene_text(
      R"("camera": {"position_m": [0, 0, 0], "look_at_m": [1, 0, 0], "vertical_fov_deg": 90, "resolution_px": [200, 100]}, "gaze_px": [100, 0], )"));
  ASSERT_TRUE(read) << read.error().message;
  const View up = scene_view(read.value());
  EXPECT_NEAR((up.gaze - Vec3(1, 0, 1).normalized()).norm(), 0,
              1e-15);  // the upper edge lies at half the field of view
  Scene right = read.value();
  right.gaze_px = {200, 50};
  EXPECT_NEAR((scene_view(right).gaze - Vec3(1, -2, 0).normalized()).norm(), 0, 1e-15);
}

TEST(Scene, TakesHowABodyMoves) {
  const Result<Scene> read = parse(scene_text("", R"([
      {"shape": "ball", "material": "hard", "static": true}, {"shape": "ball", "material": "hard", "motion": "static"},
      {"shape": "ball", "material": "hard", "motion": "kinematic", "velocity_mps": [1, 0, 0]},
      {"shape": "ball", "material": "hard", "static": false, "motion": "dynamic"}])"));
  ASSERT_TRUE(read) << read.error().message;
  const std::vector<SceneBody>& bodies = read.value().bodies;
  EXPECT_EQ(bodies[0].definition.motion, MotionType::Static);
  EXPECT_EQ(bodies[1].definition.motion, MotionType::Static);
  EXPECT_EQ(bodies[2].definition.motion, MotionType::Kinematic);
  EXPECT_EQ(bodies[2].definition.velocity_mps, Vec3(1, 0, 0));
  EXPECT_EQ(bodies[3].definition.motion, MotionType::Dynamic);
}

TEST(Scene, TakesEveryShapeAndGeneratorMember) {
  const Result<Scene> read = parse(R"({"name": "x", "description": "d", "dt_s": 1e-3, "materials": {"m": {}},
    "policy": {"kind": "random", "size": 0, "waiting": 2},
    "shapes": {"a": {"spheres": {"centers_m": [[0, 0, 0], [1, 0, 0]], "radii_m": [0.5, 0.25]}}, "b": {"tree": {"file": "t.sph", "scale": 2}}},
    "tray": {"material": "m", "side_m": 3},
    "generators": [
      {"grid": {"shapes": ["a", "b"], "mix": "seed", "material": "m", "in_tray": true, "bodies": 20, "spacing_m": 1, "bottom_m": 0.1,
                "velocity_mps": [0, 0, 1], "speed_mps": 2, "spin_radps": 3, "group": 2, "collides_with": 5, "importance": 0.5}},
      {"stream": {"shape": "a", "material": "m", "per_second": 10, "from_s": 1, "to_s": 3, "region_min_m": [0, 0, 0], "region_max_m": [1, 1, 1]}}
    ]})");
  ASSERT_TRUE(read) << read.error().message;
  const Scene& scene = read.value();
  EXPECT_EQ(scene.policy.kind, scheduler::PolicyKind::Random);
  EXPECT_EQ(scene.policy.waiting, 2);
  EXPECT_EQ(std::get<SpheresSource>(scene.shapes[0].source).spheres[1].radius_m, 0.25);
  const auto& grid = std::get<GridGenerator>(scene.generators[0]);
  EXPECT_TRUE(grid.kind.mix_by_seed);
  EXPECT_EQ(grid.kind.collides_with, 5U);
  EXPECT_EQ(std::get<StreamGenerator>(scene.generators[1]).total, 20U);
  EXPECT_EQ(generated_body_count(scene), 40U);
}

TEST(Scene, AllThatShipAreReadAndSeeTheirBodies) {
  std::size_t scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(POISE_SOURCE_DIR "/scenes")) {
    if (entry.path().extension() != ".json") continue;
    const Result<Scene> scene = read_scene(entry.path());
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene.value().name, entry.path().stem().string());
    EXPECT_FALSE(scene.value().description.empty());
    EXPECT_TRUE(scene.value().camera.has_value()) << entry.path();
    ++scenes;
  }
  EXPECT_GE(scenes, 5U);
}

TEST(Scene, ThoseOfTheAccuracyStudyAreReadAndTheirMeshesAreThere) {
  std::size_t scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(POISE_SOURCE_DIR "/scenes/accuracy")) {
    if (entry.path().extension() != ".json") continue;
    const Result<Scene> scene = read_scene(entry.path());
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene.value().name, entry.path().stem().string());
    EXPECT_FALSE(scene.value().description.empty());
    for (const SceneShape& shape : scene.value().shapes) {
      const auto* mesh = std::get_if<MeshSource>(&shape.source);
      if (mesh != nullptr) {
        EXPECT_TRUE(std::filesystem::exists(scene.value().base / mesh->file)) << mesh->file;
      }
    }
    ++scenes;
  }
  EXPECT_EQ(scenes, 11U);
}

}  // namespace
}  // namespace poise::testing
