// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "frame/scenes.h"
#include "geometry/meshes.h"

namespace poise {
namespace {

constexpr double kDt = 1.0 / 60;
constexpr double kGravity = 9.81;

WorldSettings with_gravity(double gravity_mps2 = kGravity) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -gravity_mps2);
  settings.executor = ExecutorKind::Serial;
  return settings;
}

BodyId add_driven(Stage& stage, ShapeId shape, const Vec3& position, const Vec3& velocity = Vec3::Zero(),
                  const Vec3& spin = Vec3::Zero()) {
  BodyDefinition body;
  body.shape = shape;
  body.material = stage.material;
  body.motion = MotionType::Kinematic;
  body.position_m = position;
  body.velocity_mps = velocity;
  body.angular_velocity_radps = spin;
  return stage.world.add_body(body).value();
}

/// Three balls of 1 m side by side; a smaller ball rests stably in the hollow between them.
ShapeId cradle(Stage& stage) {
  const double side = std::sqrt(0.75);
  const std::vector<Sphere> spheres = {{Vec3(1, 0, 0), 1.0}, {Vec3(-0.5, side, 0), 1.0}, {Vec3(-0.5, -side, 0), 1.0}};
  return stage.world.add_shape(make_spheres_shape(spheres).value());
}
constexpr double kInCradle = 1.1180339887498949;  // sqrt(1.5^2 - 1^2), the height of a ball of 0.5 m in it

ShapeId box(Stage& stage, const Vec3& size_m) {
  return stage.world.add_shape(
      make_mesh_shape(test::box_mesh(size_m), {.depth = 2, .preset = TreePreset::Fast}).value());
}

TEST(Kinematic, APlatformCarriesABallUpAndItsWorkIsTheBallsEnergy) {
  Stage stage(with_gravity(), 0);
  constexpr double kSpeed = 0.5;
  add_driven(stage, cradle(stage), Vec3::Zero(), Vec3(0, 0, kSpeed));
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(0, 0, kInCradle), Vec3(0, 0, kSpeed));
  const Conserved before = stage.world.conserved();
  constexpr int kSteps = 240;
  for (int frame = 0; frame < kSteps; ++frame) stage.world.step(step_of(kDt));
  const double risen_m = kSpeed * kSteps * kDt;
  EXPECT_NEAR(stage.at(ball).position_m.z(), kInCradle + risen_m, 2e-3);
  EXPECT_NEAR(stage.at(ball).velocity_mps.z(), kSpeed, 1e-3);
  const Conserved after = stage.world.conserved();
  const double mass = stage.world.mass_kg(ball).value();
  EXPECT_NEAR(after.potential_j - before.potential_j, mass * kGravity * risen_m, 1e-3 * mass * kGravity * risen_m);
  EXPECT_NEAR(after.kinetic_j, 0.5 * mass * kSpeed * kSpeed, 0.01 * 0.5 * mass * kSpeed * kSpeed)
      << "the platform is in no sum";
}

TEST(Kinematic, ABeltAcceleratesABoxByFrictionToItsSpeedAndNoFurther) {
  Stage stage(with_gravity(), 0);
  constexpr double kFriction = 0.5;
  constexpr double kSpeed = 1.5;
  stage.material = stage.world.add_material({0, kFriction, 1000}).value();
  add_driven(stage, box(stage, Vec3(10, 2, 0.5)), Vec3(0, 0, -0.25), Vec3(kSpeed, 0, 0));
  const BodyId load = stage.add(box(stage, Vec3(0.8, 0.8, 0.4)), Vec3(0, 0, 0.2));
  StepInput input = step_of(kDt);
  input.polygons = true;
  const double slips_s = kSpeed / (kFriction * kGravity);
  for (int frame = 1; frame <= 60; ++frame) {
    stage.world.step(input);
    const double expected = std::min(kSpeed, kFriction * kGravity * frame * kDt);
    const bool between = std::abs(frame * kDt - slips_s) < 1.5 * kDt;
    EXPECT_NEAR(stage.at(load).velocity_mps.x(), expected, between ? 0.1 * kSpeed : 0.02 * kSpeed) << frame;
  }
  EXPECT_NEAR(stage.at(load).position_m.z(), 0.2, 2e-3);
  EXPECT_LT(stage.at(load).angular_velocity_radps.norm(), 0.05);
}

TEST(Kinematic, WhatATurntableCarriesStaysAtItsPlace) {
  constexpr double kSpin = 1;
  constexpr double kRadiusM = 2;
  for (const double tilt : {0.0, 0.05}) {
    for (const int substeps : {1, 2, 4}) {
      WorldSettings settings = with_gravity();
      settings.substeps = substeps;
      Stage stage(settings, 0);
      stage.material = stage.world.add_material({0, 0.8, 1000}).value();
      const Quat tilted(Eigen::AngleAxisd(tilt, Vec3::UnitX()));
      BodyDefinition table;
      table.shape = box(stage, Vec3(8, 8, 0.5));
      table.material = stage.material;
      table.motion = MotionType::Kinematic;
      table.position_m = tilted * Vec3(0, 0, -0.25);
      table.orientation = tilted;
      table.angular_velocity_radps = tilted * Vec3(0, 0, kSpin);
      ASSERT_TRUE(stage.world.add_body(table).ok());
      const Vec3 place = tilted * Vec3(kRadiusM, 0, 0.2);
      const BodyId load = stage.add(box(stage, Vec3(0.8, 0.8, 0.4)), place, tilted * Vec3(0, kSpin * kRadiusM, 0),
                                    tilted * Vec3(0, 0, kSpin), tilted);
      StepInput input = step_of(kDt);
      input.polygons = true;
      for (int frame = 0; frame < 600; ++frame) stage.world.step(input);
      const Quat turned(Eigen::AngleAxisd(kSpin * 600 * kDt, tilted * Vec3::UnitZ()));
      const Vec3 where = turned.conjugate() * stage.at(load).position_m;
      // Along the tangent of each step it would be 17 cm farther out.
      EXPECT_LT((where - place).norm(), 0.003) << tilt << " rad, " << substeps << " substeps: " << where.transpose();
    }
  }
}

TEST(Kinematic, ATurningPaddleHitsABallAtTwiceItsOwnSpeedThere) {
  Stage stage(with_gravity(0), 1);
  constexpr double kSpin = 3;
  const std::vector<Sphere> spheres = {{Vec3(1, 0, 0), 0.2}, {Vec3(-1, 0, 0), 0.2}};
  const BodyId paddle = add_driven(stage, stage.world.add_shape(make_spheres_shape(spheres).value()), Vec3::Zero(),
                                   Vec3::Zero(), Vec3(0, 0, kSpin));
  const BodyId ball = stage.add(stage.ball(0.2), Vec3(0, 1, 0));
  for (int frame = 0; frame < 240 && stage.at(ball).velocity_mps.isZero(0); ++frame) {
    stage.world.step(step_of(kDt / 4));
    if (stage.at(ball).velocity_mps.isZero(0)) continue;
    ASSERT_EQ(stage.world.contacts().size(), 1U);
    const Contact& contact = stage.world.contacts()[0];
    EXPECT_EQ(contact.a, paddle);
    const Vec3 there = Vec3(0, 0, kSpin).cross(contact.point_m);
    const Vec3 expected = 2 * there.dot(contact.normal) * contact.normal;
    EXPECT_LT((stage.at(ball).velocity_mps - expected).norm(), 0.01 * expected.norm());
    EXPECT_NEAR(contact.impulse_ns.norm(), stage.world.mass_kg(ball).value() * expected.norm(),
                0.01 * stage.world.mass_kg(ball).value() * expected.norm());
  }
  EXPECT_NEAR(stage.at(ball).velocity_mps.norm(), 2 * kSpin, 0.1 * 2 * kSpin);
  EXPECT_EQ(stage.at(paddle).angular_velocity_radps, Vec3(0, 0, kSpin));
}

TEST(Kinematic, TurnsExactlyAndIsNeverPushed) {
  Stage stage(with_gravity(), 0.3);
  const Vec3 velocity(0.3, -0.2, 0.1);
  const Vec3 spin(0.4, 0.7, -1.1);
  const BodyId driven = add_driven(stage, stage.jack(), Vec3::Zero(), velocity, spin);
  const ShapeId ball = stage.ball(0.7);
  for (int i = 0; i < 6; ++i) stage.add(ball, Vec3(0.3 * i - 0.8, -0.2, 2.0 + 1.5 * i));
  ASSERT_TRUE(stage.world.apply_force(driven, Vec3(1e5, 0, 0), Vec3(0, 1, 0)));
  ASSERT_TRUE(stage.world.apply_impulse(driven, Vec3(1e5, 0, 0), Vec3(0, 1, 0)));
  std::size_t touched = 0;
  for (int frame = 0; frame < 120; ++frame) {
    stage.world.step(step_of(kDt));
    for (const Contact& contact : stage.world.contacts()) touched += contact.a == driven ? 1U : 0U;
  }
  EXPECT_GT(touched, 5U);
  const BodyState end = stage.at(driven);
  EXPECT_LT((end.position_m - 2.0 * velocity).norm(), 1e-12);
  const Quat expected(Eigen::AngleAxisd(2.0 * spin.norm(), spin.normalized()));
  EXPECT_NEAR(std::abs(end.orientation.dot(expected)), 1.0, 1e-12);
  EXPECT_EQ(end.velocity_mps, velocity);
  EXPECT_EQ(end.angular_velocity_radps, spin);
}

TEST(Kinematic, PassesThroughStaticAndKinematicBodies) {
  Stage stage(with_gravity(), 0.3);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  BodyDefinition post;
  post.shape = ball;
  post.material = stage.material;
  post.motion = MotionType::Static;
  ASSERT_TRUE(stage.world.add_body(post));
  add_driven(stage, ball, Vec3(1, 0, 0), Vec3(-1, 0, 0));
  add_driven(stage, ball, Vec3(-1, 0, 0), Vec3(1, 0, 0));
  for (int frame = 0; frame < 60; ++frame) {
    EXPECT_EQ(stage.world.step(step_of(kDt)).candidate_pairs, 0U);
    EXPECT_TRUE(stage.world.contacts().empty());
  }
}

/// The path of a ball in a moving cradle, with the cache of pairs retained or cleared each frame.
std::vector<Vec3> drive_about(bool forgetful, std::size_t& cached) {
  Stage stage(with_gravity(), 0);
  stage.material = stage.world.add_material({0, 0.4, 1000}).value();
  const BodyId driven = add_driven(stage, cradle(stage), Vec3::Zero());
  const BodyId ball = stage.add(stage.jack(), Vec3(0, 0, 1.4));
  std::vector<Vec3> way;
  for (int frame = 0; frame < 300; ++frame) {
    const double t = frame * kDt;
    EXPECT_TRUE(stage.world.set_velocity(driven, Vec3(0.6 * std::cos(2 * t), 0.3 * std::sin(3 * t), 0.2 * std::cos(t)),
                                         Vec3(0.02 * std::cos(2 * t), 0, 0.01)));
    if (forgetful) {
      const BodyState here = stage.at(driven);
      BodyState away = here;
      away.position_m.x() += 1;
      EXPECT_TRUE(stage.world.set_state(driven, away));
      EXPECT_TRUE(stage.world.set_state(driven, here));
    }
    cached += stage.world.step(step_of(kDt)).cached_contacts;
    way.push_back(stage.at(ball).position_m - stage.at(driven).position_m);
  }
  return way;
}

TEST(Kinematic, WhatPairsKeepStaysRightWhileItMoves) {
  std::size_t cached = 0;
  std::size_t anew = 0;
  const std::vector<Vec3> kept = drive_about(false, cached);
  const std::vector<Vec3> forgetful = drive_about(true, anew);
  EXPECT_GT(cached, 50U);
  EXPECT_EQ(anew, 0U);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    ASSERT_LT((kept[i] - forgetful[i]).norm(), 0.03) << i;
    ASSERT_GT(kept[i].z(), 0.6) << "it sinks in, frame " << i;
  }
}

TEST(Kinematic, WakesWhatSleepsInItsWayWhileItMoves) {
  WorldSettings settings = with_gravity();
  settings.sleeping = true;
  Stage stage(settings, 0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  const BodyId sleeper = stage.add(ball, Vec3(0, 0, 0.5));
  const BodyId driven = add_driven(stage, ball, Vec3(-3, 0, 0.5));
  for (int frame = 0; frame < 60; ++frame) stage.world.step(step_of(kDt));
  ASSERT_TRUE(stage.world.asleep(sleeper).value());
  ASSERT_TRUE(stage.world.set_velocity(driven, Vec3(1, 0, 0), Vec3::Zero()));
  int woke = -1;
  for (int frame = 0; frame < 180; ++frame) {
    stage.world.step(step_of(kDt));
    if (woke < 0 && !stage.world.asleep(sleeper).value()) woke = frame;
  }
  EXPECT_GT(woke, 100) << "far away it wakes nothing";
  EXPECT_LT(woke, 121);
  EXPECT_NEAR(stage.at(sleeper).velocity_mps.x(), 1, 0.01);
  EXPECT_GT(stage.at(sleeper).position_m.x() - stage.at(driven).position_m.x(), 0.995);
}

TEST(Kinematic, WhatASlowOneCarriesStaysAwakeAndOnAStandingOneItSleepsUntilThatMoves) {
  WorldSettings settings = with_gravity();
  settings.sleeping = true;
  Stage stage(settings, 0);
  constexpr double kSlow = 0.005;  // far below the speed that counts as still
  const BodyId driven = add_driven(stage, cradle(stage), Vec3::Zero(), Vec3(0, 0, kSlow));
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(0, 0, kInCradle));
  for (int frame = 0; frame < 120; ++frame) {
    stage.world.step(step_of(kDt));
    ASSERT_FALSE(stage.world.asleep(ball).value()) << frame;
  }
  ASSERT_TRUE(stage.world.set_velocity(driven, Vec3::Zero(), Vec3::Zero()));
  for (int frame = 0; frame < 120; ++frame) stage.world.step(step_of(kDt));
  EXPECT_TRUE(stage.world.asleep(ball).value());
  const double height_m = stage.at(ball).position_m.z();
  ASSERT_TRUE(stage.world.set_velocity(driven, Vec3(0, 0, 0.5), Vec3::Zero()));
  for (int frame = 0; frame < 60; ++frame) stage.world.step(step_of(kDt));
  EXPECT_NEAR(stage.at(ball).position_m.z(), height_m + 0.5, 0.01);
}

TEST(Kinematic, GivesTheSameBitsOnAnyThreads) {
  std::vector<std::uint64_t> first;
  for (const int threads : {1, 2, 3}) {
    WorldSettings settings = with_gravity();
    settings.executor = ExecutorKind::Threads;
    settings.threads = threads;
    settings.sleeping = true;
    Stage stage(settings, 0.2);
    stage.jacks(40, 4.0);
    add_driven(stage, stage.jack(), Vec3(0.5, 0.5, 0.8), Vec3(0.05, 0, 0), Vec3(0, 0, 2));
    add_driven(stage, stage.ball(0.4), Vec3(-1.5, 0, 0.5), Vec3(0.5, 0.1, 0));
    std::vector<std::uint64_t> hashes;
    for (int frame = 0; frame < 90; ++frame) {
      stage.world.step(step_of(kDt));
      hashes.push_back(stage.world.state_hash());
    }
    if (first.empty()) first = hashes;
    EXPECT_EQ(hashes, first) << threads;
  }
}

TEST(Kinematic, BacktrackingMeetsItWhereItIsByThen) {
  Stage stage(with_gravity(0), 1);
  const BodyId driven = add_driven(stage, stage.ball(0.5), Vec3::Zero(), Vec3(-5, 0, 0));
  const BodyId bullet = stage.add(stage.ball(0.05), Vec3(-3, 0, 0), Vec3(120, 0, 0));
  StepInput input = step_of(kDt);
  input.backtracking = true;
  std::size_t hits = 0;
  for (int frame = 0; frame < 20; ++frame) hits += stage.world.step(input).swept_hits;
  EXPECT_EQ(hits, 1U);
  EXPECT_NEAR(stage.at(bullet).velocity_mps.x(), -130, 1e-6);
  EXPECT_LT((stage.at(driven).position_m - Vec3(-5 * 20 * kDt, 0, 0)).norm(), 1e-12);
}

TEST(Kinematic, IsToldApartAndRefusedForPlanes) {
  Stage stage(with_gravity());
  const ShapeId ball = stage.ball(0.5);
  const BodyId driven = add_driven(stage, ball, Vec3::Zero(), Vec3(1, 0, 0));
  const BodyId dynamic = stage.add(ball, Vec3(5, 0, 0));
  const BodyId floor = stage.plane(Vec3::UnitZ(), -3);
  EXPECT_EQ(stage.world.motion_type(driven).value(), MotionType::Kinematic);
  EXPECT_EQ(stage.world.motion_type(dynamic).value(), MotionType::Dynamic);
  EXPECT_EQ(stage.world.motion_type(floor).value(), MotionType::Static);
  EXPECT_EQ(stage.world.mass_kg(driven).value(), 0);
  EXPECT_EQ(stage.world.step(step_of(kDt)).bodies, 1U);
  BodyDefinition plane;
  plane.shape = stage.world.add_shape(make_plane_shape(Vec3::UnitZ(), 0).value());
  plane.material = stage.material;
  plane.motion = MotionType::Kinematic;
  EXPECT_EQ(stage.world.add_body(plane).error().message, "motion: a plane must be static");
  ASSERT_TRUE(stage.world.remove_body(driven));
  EXPECT_FALSE(stage.world.motion_type(driven));
  const BodyId again = stage.add(ball, Vec3::Zero());
  EXPECT_EQ(again.slot, driven.slot);
  EXPECT_EQ(stage.world.motion_type(again).value(), MotionType::Dynamic);
}

}  // namespace
}  // namespace poise
