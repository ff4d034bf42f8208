// SPDX-License-Identifier: MIT
#include "simulation/kept_places.h"

#include <gtest/gtest.h>

#include <random>

#include "dynamics/rotation.h"
#include "scenes.h"

namespace poise {
namespace {

using collision::Patch;
using collision::Pose;

TEST(KeptPlace, FollowsBothBodies) {
  const Pose a{Vec3(1, 2, 3), dynamics::rotation_by(Vec3(0.3, -0.2, 0.5)).toRotationMatrix()};
  const Pose b{Vec3(1.5, 2.2, 4), dynamics::rotation_by(Vec3(-0.1, 0.4, 0.2)).toRotationMatrix()};
  const Patch patch{a.rotation.transpose() * Vec3::UnitZ(), Vec3(0.1, 0.2, 0.3), 0.01, 0.03};
  const response::RestPlace kept = simulation::keep({a, b}, patch);
  const response::PlaceNow here = response::place_now(a, b, kept);
  EXPECT_NEAR(here.gap_m, 0.01, 1e-14);
  EXPECT_NEAR(here.surely_m, 0.03, 1e-14);
  EXPECT_LT((here.arm_m - a.rotation * patch.point_m).norm(), 1e-14);
  // Both moved and turned alike: nothing changes. One moved along the normal: the gap does.
  const Mat3 turn = dynamics::rotation_by(Vec3(0.7, 0.1, -0.4)).toRotationMatrix();
  const Pose turned_a{turn * a.position_m, turn * a.rotation};
  const Pose turned_b{turn * b.position_m, turn * b.rotation};
  EXPECT_NEAR(response::place_now(turned_a, turned_b, kept).gap_m, 0.01, 1e-14);
  EXPECT_LT((response::place_now(turned_a, turned_b, kept).normal - turn * Vec3::UnitZ()).norm(), 1e-14);
  const Pose lifted{b.position_m + Vec3(0.02, 0, 0.05), b.rotation};
  EXPECT_NEAR(response::place_now(a, lifted, kept).gap_m, 0.06, 1e-14);
}

// What a pile knows lasts through frames that may find out nothing, or little.
TEST(KeptPlace, APileStaysAsItIsWhateverLevelsAndBudgetsItGets) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0.2);
  stage.material = stage.world.add_material({0.2, 0.5, 1000}).value();
  stage.jacks(30, 3.5);
  StepInput input;
  input.dt_s = 1.0 / 60;
  const auto height_m = [&] {
    double sum = 0;
    for (const BodyId body : stage.bodies) sum += stage.at(body).position_m.z();
    return sum / static_cast<double>(stage.bodies.size());
  };
  for (int i = 0; i < 600; ++i) stage.world.step(input);
  const double settled_m = height_m();
  std::mt19937_64 random(3);
  for (int i = 0; i < 240; ++i) {
    StepInput changed = input;
    if (i < 120) {
      changed.max_level = static_cast<Level>(random() % 3);
    } else {
      changed.budget = i / 10 % 2 == 0 ? Budget::work(0) : Budget::unlimited();
    }
    stage.world.step(changed);
    for (const BodyId body : stage.bodies) ASSERT_LT(stage.at(body).velocity_mps.norm(), 0.2) << i;
  }
  EXPECT_NEAR(height_m(), settled_m, 0.01 * settled_m);
}

}  // namespace
}  // namespace poise
