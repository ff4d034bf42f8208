// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "frame/cues/crowd_map.h"
#include "frame/cues/depth_buffer.h"
#include "frame/cues/surface_speed.h"
#include "frame/scenes.h"

namespace poise::simulation {
namespace {

View eye_along_x() { return {true, Vec3::Zero(), Vec3::UnitX(), Vec3::UnitZ(), 1.0, 16.0 / 9, Vec3::UnitX()}; }

query::InnerSolid ball(double radius_m) { return {Vec3::Zero(), radius_m, Vec3::Zero()}; }
query::InnerSolid box(const Vec3& half_m) { return {Vec3::Zero(), 0, half_m}; }

DepthBuffer behind(const query::InnerSolid& solid, const Vec3& position_m, const Mat3& rotation = Mat3::Identity()) {
  DepthBuffer buffer;
  buffer.begin(eye_along_x());
  buffer.add(solid, position_m, rotation);
  return buffer;
}

TEST(DepthBuffer, HidesWhatIsWhollyBehindAWallAndNothingElse) {
  const DepthBuffer buffer = behind(box(Vec3(0.1, 2, 2)), Vec3(5, 0, 0));
  EXPECT_TRUE(buffer.hides(Vec3(10, 0, 0), 0.5));
  EXPECT_TRUE(buffer.hides(Vec3(10, 2, 1), 0.5));
  EXPECT_FALSE(buffer.hides(Vec3(3, 0, 0), 0.5)) << "before it";
  EXPECT_FALSE(buffer.hides(Vec3(5, 0, 0), 0.5)) << "it stands out before it";
  EXPECT_FALSE(buffer.hides(Vec3(10, 4, 0), 0.5)) << "a part of it is beside the wall";
  EXPECT_FALSE(buffer.hides(Vec3(10, 0, 0), 4.5)) << "larger than the wall";
  EXPECT_FALSE(buffer.hides(Vec3(-10, 0, 0), 0.5)) << "behind the eye";
  EXPECT_FALSE(buffer.hides(Vec3(10, 30, 0), 0.5)) << "outside the image";
}

TEST(DepthBuffer, DrawsNothingThatTheEyeIsInOrThatIsBehindIt) {
  EXPECT_FALSE(behind(box(Vec3(3, 3, 3)), Vec3::Zero()).hides(Vec3(10, 0, 0), 0.1));
  EXPECT_FALSE(behind(box(Vec3(1, 9, 9)), Vec3(-3, 0, 0)).hides(Vec3(10, 0, 0), 0.1));
}

TEST(DepthBuffer, AWallOfSeveralHidesWhatNoneOfThemHidesAlone) {
  DepthBuffer buffer = behind(box(Vec3(0.1, 0.5, 2)), Vec3(5, -0.45, 0));
  EXPECT_FALSE(buffer.hides(Vec3(10, 0, 0), 0.4));
  buffer.add(box(Vec3(0.1, 0.5, 2)), Vec3(5, 0.45, 0), Mat3::Identity());
  EXPECT_TRUE(buffer.hides(Vec3(10, 0, 0), 0.4));
}

// Does the segment from the eye to a point meet a solid?
bool covered(const query::InnerSolid& solid, const Vec3& position_m, const Mat3& rotation, const Vec3& point_m) {
  for (int i = 1; i < 400; ++i) {
    const Vec3 at = rotation.transpose() * (point_m * (i / 400.0) - position_m);
    if (solid.radius_m > 0 ? at.norm() <= solid.radius_m
                           : (at.cwiseAbs().array() <= solid.half_extents_m.array()).all())
      return true;
  }
  return false;
}

TEST(DepthBuffer, NeverHidesABallOfWhichAPointIsSeen) {
  std::mt19937_64 random(3);
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-52 - 1.0; };
  const auto vector = [&] {
    const double x = unit(), y = unit(), z = unit();
    return Vec3(x, y, z);
  };
  int hidden = 0;
  for (int i = 0; i < 4000; ++i) {
    const query::InnerSolid solid = i % 2 == 0 ? ball(1 + 0.8 * unit()) : box(Vec3(0.9, 0.9, 0.9) + 0.7 * vector());
    const Vec3 position_m = Vec3(5, 0, 0) + vector();
    const Mat3 rotation = Quat(unit(), unit(), unit(), unit()).normalized().toRotationMatrix();
    const Vec3 center_m = position_m * (1.5 + 0.5 * unit()) + 0.6 * vector();
    const double radius_m = 0.25 + 0.2 * unit();
    if (!behind(solid, position_m, rotation).hides(center_m, radius_m)) continue;
    ++hidden;
    for (int k = 0; k < 20; ++k) {
      const Vec3 point_m = center_m + 0.98 * radius_m * vector().normalized();
      EXPECT_TRUE(covered(solid, position_m, rotation, point_m)) << i;
    }
  }
  EXPECT_GT(hidden, 300);
}

TEST(CrowdMap, CountsTheOthersOfACellAndNothingOutsideTheImage) {
  CrowdMap crowd;
  crowd.begin(eye_along_x());
  for (int i = 0; i < 5; ++i) crowd.add(Vec3(10, 0.1, 0.1), 1);
  crowd.add(Vec3(10, 0.1, -3), 1);
  crowd.add(Vec3(-10, 0.1, 0.1), 1);
  crowd.add(Vec3(10, 40, 0), 1);
  EXPECT_EQ(crowd.others_at(Vec3(20, 0.2, 0.2)), 4) << "the same place of the image";
  EXPECT_EQ(crowd.others_at(Vec3(10, 0.1, -3)), 0);
  EXPECT_EQ(crowd.others_at(Vec3(10, 2, 2)), 0);
  EXPECT_EQ(crowd.others_at(Vec3(-10, 0.1, 0.1)), 0);
  EXPECT_EQ(crowd.others_at(Vec3(10, 40, 0)), 0);
}

TEST(CrowdMap, AnEventMayStandForMoreUpToItsLimit) {
  CrowdMap crowd;
  crowd.begin(eye_along_x());
  crowd.add(Vec3(10, 0, 0), 1e9F);
  EXPECT_EQ(crowd.others_at(Vec3(10, 0, 0)), 65535);
}

/// What one frame says of its pairs: a pair of jacks that touch, with a budget of nothing.
class Measured : public ::testing::Test {
 protected:
  static WorldSettings settings() {
    WorldSettings settings;
    settings.threads = 1;
    settings.policy.occlusion = settings.policy.gap = settings.policy.crowding = settings.policy.attention = 1;
    settings.policy.delay = settings.policy.onset = 1;
    return settings;
  }
  // Explains the last of some steps, which has a budget of nothing, from its own record.
  static FrameExplanation explain(const std::function<void(Stage&)>& fill, StepInput input, int frames = 1,
                                  WorldSettings with = settings(), const Budget& before = Budget::work(0)) {
    FrameExplanation explanation;
    Stage first(with), second(with);
    fill(first);
    fill(second);
    for (int frame = 0; frame < frames; ++frame) {
      FrameDecisions decisions;
      input.budget = frame + 1 < frames ? before : Budget::work(0);
      input.record = true;
      first.world.step(input);
      first.world.decisions(decisions);
      StepInput again = input;
      again.record = false;
      again.replay = &decisions;
      again.explain = &explanation;
      second.world.step(again);
      EXPECT_EQ(first.world.state_hash(), second.world.state_hash());
    }
    return explanation;
  }
  static StepInput seen_from(const Vec3& eye_m) {
    StepInput input = step_of(1.0 / 60);
    const Vec3 forward = -eye_m.normalized();
    input.view = {true, eye_m, forward, Vec3::UnitZ(), 0.87, 1.78, forward};
    return input;
  }
};

TEST(SurfaceSpeed, AddsTheSpinAtTheContactPointToTheVelocity) {
  PredictedMotion motion;
  ActivePair pair;
  pair.a = 0;
  pair.b = 1;
  motion.spins_radps.assign(2, Vec3::Zero());
  motion.poses.assign(2, {});
  motion.body_bounds.assign(2, {});
  motion.poses[pair.b].position_m = Vec3(2, 0, 0);
  motion.body_bounds[pair.a].velocity_mps = Vec3(1, 0, 0);
  const PairPlace beside{Vec3(1, 0.5, 0), Vec3::UnitX()};
  EXPECT_NEAR(surface_closing_mps(motion, pair, beside), 1, 1e-15);
  motion.spins_radps[pair.a] = Vec3(0, 0, -4);
  EXPECT_NEAR(surface_closing_mps(motion, pair, beside), 1 + 4 * 0.5, 1e-15);
  motion.spins_radps[pair.b] = Vec3(0, 0, 4);
  EXPECT_NEAR(surface_closing_mps(motion, pair, beside), 1 + 8 * 0.5, 1e-15);
  const PairPlace between{Vec3(1, 0, 0), Vec3::UnitX()};
  EXPECT_NEAR(surface_closing_mps(motion, pair, between), 1, 1e-15) << "spin moves it across the normal";
}

TEST_F(Measured, APairIsSeenWhereItsCachedPointIs) {
  const StepInput input = seen_from(Vec3(0, -9, 0));
  const auto eccentricity_rad = [&](bool cached) {
    return explain(
               [&](Stage& stage) {
                 const ShapeId jack = stage.jack();
                 stage.add(jack, Vec3(0, 0, 0));
                 stage.add(jack, Vec3(0.3, 0, 1));
                 // A frame that ends at level 1 caches the points of the arms that touch.
                 StepInput coarse = input;
                 coarse.max_level = 1;
                 if (cached) stage.world.step(coarse);
               },
               input)
        .pairs.at(0)
        .cues.eccentricity_rad;
  };
  EXPECT_GT(std::abs(eccentricity_rad(true) - eccentricity_rad(false)), 1e-3);
}

TEST_F(Measured, APairBehindAWallIsHiddenAndRatedLowerButNotZero) {
  const auto pair_and_wall = [](double wall_y_m) {
    return [wall_y_m](Stage& stage) {
      const ShapeId jack = stage.jack();
      stage.add(jack, Vec3(0, 0, 0));
      stage.add(jack, Vec3(1.2, 0.3, 0));
      BodyDefinition wall;
      wall.shape = stage.ball(3);
      wall.material = stage.material;
      wall.motion = MotionType::Static;
      wall.position_m = Vec3(0.5, wall_y_m, 0);
      EXPECT_TRUE(stage.world.add_body(wall));
    };
  };
  const StepInput input = seen_from(Vec3(0, -12, 0));
  const FrameExplanation hidden = explain(pair_and_wall(-6), input);
  const FrameExplanation open = explain(pair_and_wall(8), input);
  ASSERT_EQ(hidden.pairs.size(), 1U);
  ASSERT_EQ(open.pairs.size(), 1U);
  EXPECT_TRUE(hidden.pairs[0].cues.hidden);
  EXPECT_FALSE(open.pairs[0].cues.hidden);
  EXPECT_NEAR(hidden.pairs[0].weight, 0.25 * open.pairs[0].weight, 1e-12);
  EXPECT_GT(hidden.pairs[0].next_score, 0);
}

TEST_F(Measured, AttentionIsOnTheBodyOrTheBallOfSpaceThatTheHostNames) {
  BodyId chosen;
  const auto two_pairs = [&chosen](Stage& stage) {
    const ShapeId jack = stage.jack();
    stage.add(jack, Vec3(0, 0, 0));
    stage.add(jack, Vec3(1.2, 0.3, 0));
    chosen = stage.add(jack, Vec3(20, 0, 0));
    stage.add(jack, Vec3(21.2, 0.3, 0));
  };
  const auto attended = [&](const Attention& attention) {
    StepInput input = step_of(1.0 / 60);
    input.attention = attention;
    const FrameExplanation explained = explain(two_pairs, input);
    EXPECT_EQ(explained.pairs.size(), 2U);
    return std::pair(explained.pairs.at(0).cues.attended, explained.pairs.at(1).cues.attended);
  };
  EXPECT_EQ(attended({}), std::pair(false, false));
  EXPECT_EQ(attended({Vec3(0.6, 0, 0), 2, {}}), std::pair(true, false));
  EXPECT_EQ(attended({Vec3::Zero(), 0, chosen}), std::pair(false, true));
  EXPECT_EQ(attended({Vec3::Zero(), 0, BodyId{chosen.slot, chosen.generation + 1}}), std::pair(false, false));
}

TEST_F(Measured, AttentionThatIsNoNumberIsRefused) {
  Stage stage(settings());
  StepInput input = step_of(1.0 / 60);
  input.attention.radius_m = -1;
  EXPECT_EQ(stage.world.step(input).status, StepStatus::RefusedView);
  input.attention = {Vec3(std::nan(""), 0, 0), 1, {}};
  EXPECT_EQ(stage.world.step(input).status, StepStatus::RefusedView);
}

TEST_F(Measured, TheAgeOfAContactCountsFromItsBeginning) {
  // A jack that lies on a plane touches it in each frame.
  const auto lying = [](Stage& stage) {
    stage.plane(Vec3::UnitZ(), 0);
    stage.add(stage.jack(), Vec3(0, 0, 0.4));
  };
  WorldSettings with = settings();
  with.gravity_mps2 = Vec3(0, 0, -9.81);
  const double dt_s = 1.0 / 60;
  const auto age = [&](int frames) {
    return static_cast<double>(explain(lying, step_of(dt_s), frames, with).pairs.at(0).cues.age_s);
  };
  EXPECT_EQ(age(1), 0.0) << "it has not touched yet";
  EXPECT_NEAR(age(3), 2 * dt_s, 1e-6);
  EXPECT_NEAR(age(6), 5 * dt_s, 1e-6);
}

TEST_F(Measured, CuesThatAreOffAreNotMeasured) {
  const auto two = [](Stage& stage) {
    const ShapeId jack = stage.jack();
    stage.add(jack, Vec3(0, 0, 0), Vec3(1, 0, 0));
    stage.add(jack, Vec3(0.7, 0.2, 0));
  };
  WorldSettings off = settings();
  for (const scheduler::PolicyField& weight : scheduler::policy_weights()) off.policy.*weight.value = 0;
  const StepInput input = seen_from(Vec3(3, -9, 0));
  const scheduler::PairCues measured = explain(two, input).pairs.at(0).cues;
  const scheduler::PairCues unmeasured = explain(two, input, 1, off).pairs.at(0).cues;
  EXPECT_GT(measured.closing_mps, 0);
  EXPECT_GT(measured.eccentricity_rad, 0);
  EXPECT_GT(measured.gap_rad, 0);
  EXPECT_EQ(unmeasured.closing_mps, 0);
  EXPECT_EQ(unmeasured.eccentricity_rad, 0);
  EXPECT_EQ(unmeasured.gap_rad, 0);
  EXPECT_NE(measured.separation, 0);
  EXPECT_EQ(unmeasured.separation, 0);
}

TEST_F(Measured, TheSeparationOfWhatIsNotKnownIsThatOfItsRootSpheres) {
  const auto at = [&](double distance_m, int frames) {
    const auto two = [distance_m](Stage& stage) {
      const ShapeId jack = stage.jack();
      stage.add(jack, Vec3(0, 0, 0));
      stage.add(jack, Vec3(distance_m, 0, 0.1));
    };
    return explain(two, step_of(1.0 / 60), frames).pairs.at(0).cues.separation;
  };
  EXPECT_LT(at(0.5, 1), at(0.7, 1)) << "deeper";
  EXPECT_LT(at(0.7, 1), at(0.9, 1));
  EXPECT_LT(at(0.5, 1), -0.3F);
}

TEST_F(Measured, TheSeparationOfWhatWasFoundApartIsLargeUntilItHasMoved) {
  // Beside each other, found apart in the first frame, and turning fast.
  const auto turning = [](Stage& stage) {
    const ShapeId jack = stage.jack();
    stage.add(jack, Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, 3));
    stage.add(jack, Vec3(0.85, 0.6, 0.55));
  };
  const auto separation = [&](int frames) {
    const FrameExplanation explained = explain(turning, step_of(1.0 / 60), frames, settings(), Budget::unlimited());
    return explained.pairs.at(0).cues.separation;
  };
  const float unknown = separation(1);
  EXPECT_GT(separation(2), 2 * unknown) << "it cannot touch yet";
  EXPECT_LT(separation(4), separation(2)) << "what was found gets old";
}

TEST_F(Measured, ADelayIsThatOfSurfacesThatApproach) {
  const auto closing = [](double speed_mps) {
    return [speed_mps](Stage& stage) {
      const ShapeId jack = stage.jack();
      stage.add(jack, Vec3(0, 0, 0), Vec3(speed_mps, 0, 0));
      stage.add(jack, Vec3(1.3, 0, 0.9));
    };
  };
  const auto delay = [&](double speed_mps) {
    return static_cast<double>(explain(closing(speed_mps), step_of(1.0 / 60), 4).pairs.at(0).cues.delay_s);
  };
  EXPECT_NEAR(delay(0.01), 3.0 / 60, 1e-6) << "waited for three frames";
  EXPECT_EQ(delay(-0.01), 0.0);
}

}  // namespace
}  // namespace poise::simulation
