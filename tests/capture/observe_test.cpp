// SPDX-License-Identifier: MIT
#include "capture/observe.h"

#include <gtest/gtest.h>

#include <map>

#include "scene/scene_text.h"

namespace poise::capture {
namespace {

using testing::run_of;

Scene scene_of(const std::string& text) {
  const Result<Scene> scene = testing::parse(text);
  EXPECT_TRUE(scene) << scene.error().message;
  return scene.value();
}

// A step of 1/64 s. A floor, a static and a kinematic ball, and one that lies on the floor and one that falls.
const char* const kScene = R"({"name": "x", "dt_s": 0.015625, "gravity_mps2": [0, 0, -9.8], "sleeping": true,
  "materials": {"m": {"friction": 0.5}},
  "shapes": {"ball": {"sphere": {"radius_m": 0.5}}, "floor": {"plane": {"normal": [0, 0, 1]}},
             "two": {"spheres": {"centers_m": [[0, 0, 0], [0.4, 0, 0]], "radii_m": [0.3, 0.3]}}},
  "camera": {"position_m": [9, 0, 3], "look_at_m": [0, 0, 0], "resolution_px": [800, 400], "vertical_fov_deg": 60},
  "gaze_px": [600, 100],
  "bodies": [{"name": "ground", "shape": "floor", "material": "m", "motion": "static"},
             {"shape": "ball", "material": "m", "motion": "static", "position_m": [5, 0, 9]},
             {"shape": "ball", "material": "m", "motion": "kinematic", "position_m": [-5, 0, 9], "velocity_mps": [0, 1, 0]},
             {"name": "lies", "shape": "ball", "material": "m", "position_m": [0, 0, 0.5]},
             {"shape": "two", "material": "m", "position_m": [0, 5, 90]}],
  "generators": [{"stream": {"shape": "ball", "material": "m", "total": 2, "per_second": 16, "life_s": 0.25,
                  "region_min_m": [20, 0, 0], "region_max_m": [20, 90, 90]}}]})";

TEST(FrameObserver, TellsPosesStatesLevelsAndRowsOfEveryFrame) {
  const Scene scene = scene_of(kScene);
  SceneRun run = run_of(scene);
  FrameObserver observer(scene, run, true, true);
  std::vector<CapturedBody> rows;
  bool slept = false;
  bool touched = false;
  for (std::uint64_t k = 0; k < 120; ++k) {
    ASSERT_TRUE(run.before_frame(k));
    StepInput input;
    input.dt_s = scene.dt_s;
    input.view = run.view();
    const FrameReport report = run.world().step(input);
    SeenFrame frame;
    ASSERT_TRUE(observer.observe(frame).ok());
    rows.insert(rows.end(), frame.new_bodies.begin(), frame.new_bodies.end());
    ASSERT_EQ(frame.bodies.size(), run.bodies().size());
    for (std::size_t i = 0; i < frame.bodies.size(); ++i) {
      const BodyState state = run.world().state(run.bodies()[i].id).value();
      EXPECT_EQ(frame.bodies[i].number, run.bodies()[i].number);
      EXPECT_EQ(frame.bodies[i].pose.position_m, state.position_m);
      EXPECT_EQ(frame.bodies[i].pose.orientation.coeffs(), state.orientation.coeffs());
    }
    const auto activity = [&](std::size_t i) { return static_cast<BodyActivity>(frame.bodies[i].activity); };
    EXPECT_EQ(activity(0), BodyActivity::Static);
    EXPECT_EQ(activity(1), BodyActivity::Static);
    EXPECT_EQ(activity(2), BodyActivity::Kinematic);
    EXPECT_EQ(activity(4), BodyActivity::Moving);
    EXPECT_EQ(frame.bodies[4].level, 0) << "nothing is near";
    const bool asleep = run.world().asleep(run.bodies()[3].id).value();
    EXPECT_EQ(activity(3), asleep ? BodyActivity::Asleep : BodyActivity::Moving);
    EXPECT_EQ(frame.bodies[3].level, 1) << "a ball on a plane is at level 0, asleep too";
    slept = slept || asleep;
    EXPECT_EQ(frame.contacts.size(), run.world().contacts().size());
    for (const SeenContact& contact : frame.contacts) {
      touched = true;
      EXPECT_EQ(contact.a, 0U);
      EXPECT_EQ(contact.b, 3U);
      EXPECT_NEAR(std::abs(contact.normal.z()), 1, 1e-6);
      EXPECT_NEAR(contact.points_m[0].z(), 0, 0.01);
    }
    std::uint64_t left = 0;
    for (const SeenPair& pair : frame.pairs) {
      left += (pair.packed.state & kPairLeft) != 0 ? 1U : 0U;
      if (pair.a != 3U) continue;
      EXPECT_EQ(pair.b, 0U) << "a plane is always second";
      EXPECT_EQ(pair.packed.level, 0);
      EXPECT_EQ(pair.packed.deepest, 0);
      EXPECT_EQ(pair.packed.error, 0) << "a ball is its sphere";
      EXPECT_EQ(pair.packed.outcome, 1 + static_cast<int>(PairOutcome::Deepest));
      EXPECT_EQ(pair.packed.turn, 0) << "without a budget nothing is ranked";
    }
    EXPECT_EQ(left, report.pairs_left);
    const FrameFacts facts = facts_of(report, run.view(), scene.dt_s);
    EXPECT_EQ(facts.frame, k + 1);
    EXPECT_EQ(facts.time_s, static_cast<double>(k + 1) / 64);
    EXPECT_EQ(facts.counts[3], report.contact_pairs);
    EXPECT_EQ(facts.levels[0], report.level_histogram[0]);
  }
  EXPECT_TRUE(slept);
  EXPECT_TRUE(touched);
  ASSERT_EQ(rows.size(), 7U) << "those of the stream too, which have left";
  EXPECT_EQ(rows[0].name, "ground");
  EXPECT_EQ(rows[3].name, "lies");
  EXPECT_EQ(rows[3].mass_kg, run.world().mass_kg(run.bodies()[3].id).value());
  EXPECT_EQ(rows[2].motion, MotionType::Kinematic);
  EXPECT_EQ(rows[2].mass_kg, 0);
  EXPECT_EQ(rows[6].number, 6U);
}

TEST(CaptureHeader, OfASceneHasItsShapesAndAThousandthOfTheSmallestRadius) {
  const Scene scene = scene_of(kScene);
  SceneRun run = run_of(scene);
  const CaptureHeader header = header_of(scene, run);
  EXPECT_DOUBLE_EQ(header.position_step_m, 5e-4) << "balls of 0.5 m";
  ASSERT_EQ(header.shapes.size(), 3U);
  EXPECT_EQ(header.shapes[0].levels.at(0).at(0).radius_m, 0.5F);
  EXPECT_TRUE(header.shapes[1].plane);
  EXPECT_EQ(header.shapes[2].levels.back().size(), 2U);
  EXPECT_EQ(header.gravity_mps2[2], -9.8);
  ASSERT_TRUE(header.camera);
  EXPECT_FALSE(header.camera->moves);
  EXPECT_EQ(header.materials.at(0).friction, 0.5);
}

TEST(CaptureFacts, HaveTheGazeInPixels) {
  const Scene scene = scene_of(kScene);
  SceneRun run = run_of(scene);
  FrameFacts facts = facts_of_start(run.view());
  find_gaze(run.view(), scene.camera->resolution_px, facts);
  EXPECT_TRUE(facts.has_view);
  EXPECT_NEAR(facts.gaze_px[0], 600, 1e-2);
  EXPECT_NEAR(facts.gaze_px[1], 100, 1e-2);
}

TEST(CaptureFacts, HoldTimesThatDoNotFitAtTheirEnd) {
  EXPECT_EQ(captured_time(Nanoseconds(-5)), 0U);
  EXPECT_EQ(captured_time(Nanoseconds(12345)), 123U);
  EXPECT_EQ(captured_time(Nanoseconds(INT64_MAX)), 0xffffffffU);
}

}  // namespace
}  // namespace poise::capture
