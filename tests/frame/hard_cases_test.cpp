// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "frame/scenes.h"
#include "geometry/meshes.h"

namespace poise {
namespace {

void expect_sane(const Stage& stage) {
  for (const BodyId body : stage.bodies) {
    const BodyState state = stage.at(body);
    ASSERT_TRUE(state.position_m.allFinite() && state.velocity_mps.allFinite() &&
                state.angular_velocity_radps.allFinite());
    ASSERT_NEAR(state.orientation.norm(), 1, 1e-9);
  }
}

double total_j(const Stage& stage) {
  const Conserved sums = stage.world.conserved();
  return sums.kinetic_j + sums.potential_j;
}

TEST(HardCases, BodiesInTheSamePlaceComeApartCalmly) {
  Stage stage({}, 0);
  const ShapeId ball = stage.ball(0.5);
  for (int i = 0; i < 20; ++i) stage.add(ball, Vec3::Zero());
  for (int i = 0; i < 600; ++i) {
    stage.world.step(step_of(1.0 / 60));
    EXPECT_LT(stage.world.conserved().kinetic_j, 1e-6);
  }
  expect_sane(stage);
}

TEST(HardCases, ThousandsSpawnedOverlappingStayFiniteAndGainNoEnergy) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0.5);
  stage.tray(6);
  const ShapeId ball = stage.ball(0.3);
  std::mt19937_64 random(9);
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-53 - 0.5; };
  for (int i = 0; i < 1000; ++i) stage.add(ball, Vec3(3 * unit(), 3 * unit(), 2 + 2 * unit()));
  for (int i = 0; i < 120; ++i) stage.world.step(step_of(1.0 / 60));
  expect_sane(stage);
  double fastest = 0;
  for (const BodyId body : stage.bodies) fastest = std::max(fastest, stage.at(body).velocity_mps.norm());
  EXPECT_LT(fastest, 12) << "nothing is thrown faster than it could have fallen";
}

TEST(HardCases, MassRatiosOfAMillionStayFinite) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0.3);
  stage.plane(Vec3::UnitZ(), 0);
  for (int i = 0; i < 2; ++i) {
    BodyDefinition body;
    body.shape = stage.ball(0.5);
    body.material = stage.material;
    body.mass_kg = i == 0 ? 1e-3 : 1e3;
    body.position_m = Vec3(0, 0, 0.5 + 1.05 * i);
    stage.bodies.push_back(stage.world.add_body(body).value());
  }
  const double start = total_j(stage);
  for (int i = 0; i < 600; ++i) {
    stage.world.step(step_of(1.0 / 60));
    ASSERT_LE(total_j(stage), start * (1 + 1e-9));
  }
  expect_sane(stage);
}

// A heavy plate on balls is a cart without friction: nothing drives it, and what sets it rolling does not grow.
TEST(HardCases, APlateOnBallsStandsStill) {
  constexpr int kSide = 11;
  for (const bool plate_first : {true, false}) {
    Stage stage(one_thread_with_gravity(), 0);
    stage.material = stage.world.add_material({0, 0.5, 1000}).value();
    stage.plane(Vec3::UnitZ(), 0);
    TreeBuildOptions tree;
    tree.depth = 2;
    tree.preset = TreePreset::Fast;
    const ShapeId plate = stage.world.add_shape(make_mesh_shape(test::box_mesh(Vec3(2.4, 2.4, 0.2)), tree).value());
    const ShapeId ball = stage.ball(0.05);
    const auto add_plate = [&] {
      BodyDefinition body;
      body.shape = plate;
      body.material = stage.material;
      body.mass_kg = 500;
      body.position_m = Vec3(0, 0, 0.2);
      body.velocity_mps = Vec3(1e-5, 0, 0);
      return stage.world.add_body(body).value();
    };
    BodyId heavy;
    if (plate_first) heavy = add_plate();
    for (int i = 0; i < kSide * kSide; ++i) stage.add(ball, Vec3(0.2 * (i % kSide - 5), 0.2 * (i / kSide - 5), 0.05));
    if (!plate_first) heavy = add_plate();
    FrameReport report;
    StepInput input = step_of(1.0 / 60);
    input.polygons = true;
    for (int i = 0; i < 240; ++i) report = stage.world.step(input);
    EXPECT_GT(report.colors_full, 0U) << "it has more pairs than there are colours";
    EXPECT_GT(report.cached_contacts, 100U) << "few are found anew";
    EXPECT_LT(stage.at(heavy).velocity_mps.norm(), 1e-4);
    EXPECT_NEAR(stage.at(heavy).position_m.z(), 0.2, 1e-4);
    EXPECT_LT(stage.world.conserved().kinetic_j, 1e-5);
  }
}

// Towers of boxes, balls and slabs with masses between a gram and a tonne.
class TowersOfAnyMasses : public testing::TestWithParam<double> {};

TEST_P(TowersOfAnyMasses, GainNoEnergy) {
  std::mt19937_64 random(5);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1.0p-53;
  };
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  TreeBuildOptions tree;
  tree.depth = 2;
  tree.preset = TreePreset::Fast;
  const ShapePtr shapes[] = {make_mesh_shape(test::box_mesh(Vec3(1, 1, 1)), tree).value(),
                             make_sphere_shape(0.5).value(),
                             make_mesh_shape(test::box_mesh(Vec3(2, 2, 0.2)), tree).value()};
  const double heights[] = {1, 1, 0.2};
  for (int tower = 0; tower < 10; ++tower) {
    Stage stage(settings, 0);
    stage.material = stage.world.add_material({0, GetParam(), 1000}).value();
    stage.plane(Vec3::UnitZ(), 0);
    double top_m = 0;
    const auto count = static_cast<int>(between(2, 10));
    for (int i = 0; i < count; ++i) {
      const auto kind = static_cast<std::size_t>(between(0, 3));
      BodyDefinition body;
      body.shape = stage.world.add_shape(shapes[kind]);
      body.material = stage.material;
      body.mass_kg = std::pow(10, between(-3, 3));
      body.position_m = Vec3(between(-0.05, 0.05), between(-0.05, 0.05), top_m + 0.5 * heights[kind]);
      stage.bodies.push_back(stage.world.add_body(body).value());
      top_m += heights[kind];
    }
    const double start = total_j(stage);
    double most = start;
    for (int i = 0; i < 240; ++i) {
      StepInput input = step_of(1.0 / 60);
      input.polygons = tower % 2 == 0;
      stage.world.step(input);
      most = std::max(most, total_j(stage));
    }
    expect_sane(stage);
    // Depenetration may lift a body.
    EXPECT_LT(most, (1 + 1e-3) * start) << "tower " << tower << " of " << count;
  }
}

INSTANTIATE_TEST_SUITE_P(HardCases, TowersOfAnyMasses, testing::Values(0.0, 0.5, 1.0));

TEST(HardCases, FastFarAndSpinningBodiesStaySane) {
  for (const double dt_s : {1e-4, 1.0 / 60, 0.1}) {
    Stage stage({}, 1);
    const Vec3 far(1e7, -1e7, 1e7);
    const ShapeId jack = stage.jack();
    stage.add(jack, far, Vec3(1000, 0, 0));
    stage.add(jack, far + Vec3(3, 0.2, 0), Vec3(-1000, 0, 0), Vec3(1e4, -5e3, 2e3));
    stage.add(jack, far + Vec3(0, 3, 0), Vec3::Zero(), Vec3(0, 1e4, 0));
    const double start = stage.world.conserved().kinetic_j;
    for (int i = 0; i < 100; ++i) stage.world.step(step_of(dt_s));
    expect_sane(stage);
    EXPECT_NEAR(stage.world.conserved().kinetic_j, start, 1e-6 * start);
  }
}

TEST(HardCases, AnElasticGasKeepsItsEnergyOverManyImpacts) {
  Stage stage({}, 1);
  for (const int axis : {0, 1, 2}) {
    for (const double side : {-1.0, 1.0}) stage.plane(side * Vec3::Unit(axis), -2);
  }
  const ShapeId ball = stage.ball(0.2);
  std::mt19937_64 random(2);
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-53 - 0.5; };
  for (int i = 0; i < 125; ++i) {
    stage.add(ball, 0.7 * Vec3(i % 5 - 2, (i / 5) % 5 - 2, i / 25 - 2), 6 * Vec3(unit(), unit(), unit()));
  }
  const double start = total_j(stage);
  std::size_t impacts = 0;
  for (int i = 0; i < 3000; ++i) {
    stage.world.step(step_of(1.0 / 120));
    for (const Contact& contact : stage.world.contacts()) impacts += contact.impulse_ns.squaredNorm() > 0 ? 1U : 0U;
  }
  EXPECT_GT(impacts, 10'000U);
  EXPECT_NEAR(total_j(stage), start, 1e-11 * start);
  expect_sane(stage);
  for (const BodyId body : stage.bodies) EXPECT_LT(stage.at(body).position_m.cwiseAbs().maxCoeff(), 2);
}

TEST(HardCases, LevelsThatFlipEveryFrameAddNoEnergy) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0.2);
  stage.jacks(150, 5);
  const double start = total_j(stage);
  for (int i = 0; i < 400; ++i) {
    StepInput input = step_of(1.0 / 60);
    input.max_level = static_cast<Level>(i % 3);
    stage.world.step(input);
    ASSERT_LE(total_j(stage), start * (1 + 1e-9));
  }
  expect_sane(stage);
}

}  // namespace
}  // namespace poise
