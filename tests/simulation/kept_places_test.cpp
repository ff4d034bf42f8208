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

// How far two of Stage's jacks overlap, sphere by sphere.
double overlap_m(const BodyState& a, const BodyState& b) {
  std::vector<Sphere> spheres = {{Vec3::Zero(), 0.28}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      spheres.push_back({side * 0.35 * Vec3::Unit(axis), 0.22});
      spheres.push_back({side * 0.68 * Vec3::Unit(axis), 0.18});
    }
  }
  double most = 0;
  for (const Sphere& x : spheres) {
    for (const Sphere& y : spheres) {
      const double distance = (a.position_m + a.orientation * x.center_m - b.position_m - b.orientation * y.center_m).norm();
      most = std::max(most, x.radius_m + y.radius_m - distance);
    }
  }
  return most;
}

// Pairs that are apart by much are not asked for many frames; whatever they do meanwhile, they meet in time.
TEST(KeptClearance, IsGivenUpBeforeThePairMeets) {
  std::mt19937_64 random(11);
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-53 - 0.5; };
  std::size_t kept = 0;
  int met = 0;
  for (int round = 0; round < 60; ++round) {
    Stage stage({}, 0);
    const ShapeId jack = stage.jack();
    std::array<double, 14> drawn{};
    for (double& number : drawn) number = unit();
    const BodyId a = stage.add(jack, Vec3::Zero(), Vec3::Zero(), Vec3(drawn[0], drawn[1], drawn[2]), Quat(drawn[3], drawn[4], drawn[5], drawn[6]));
    const BodyId b = stage.add(jack, Vec3(1.8, 0.6 * drawn[7], 0.6 * drawn[8]), Vec3(-0.3, 0.1 * drawn[9], 0.1 * drawn[10]),
                               Vec3(drawn[11], drawn[12], drawn[13]), Quat(1, drawn[9], drawn[7], drawn[8]));
    for (int i = 0; i < 240; ++i) {
      const FrameReport report = stage.world.step(step_of(1.0 / 60));
      kept += report.kept_apart;
      met += report.contact_pairs > 0 ? 1 : 0;
      // What a step closes at 0.3 m/s and half a radian a second is 1 cm.
      ASSERT_LT(overlap_m(stage.at(a), stage.at(b)), 5e-3) << round << " after " << i;
    }
  }
  EXPECT_GT(kept, 500U) << "clearances are used";
  EXPECT_GT(met, 100) << "and pairs meet";
}

}  // namespace
}  // namespace poise
