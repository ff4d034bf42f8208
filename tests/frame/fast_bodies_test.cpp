// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "frame/scenes.h"
#include "geometry/meshes.h"

namespace poise {
namespace {

constexpr double kBulletM = 0.025;  // radius
constexpr double kPlateM = 0.02;    // thickness
constexpr double kSpeed = 500;

enum class PlateKind { Mesh, Balls, Plane };

ShapePtr plate_shape(PlateKind kind) {
  if (kind == PlateKind::Plane) return make_plane_shape(Vec3::UnitZ(), 0.5 * kPlateM).value();
  if (kind == PlateKind::Mesh) {
    static const ShapePtr shape =
        make_mesh_shape(test::box_mesh(Vec3(1, 1, kPlateM)), {.depth = 2, .preset = TreePreset::Fast}).value();
    return shape;
  }
  static const ShapePtr union_of_balls = [] {
    std::vector<Sphere> balls;
    for (int x = -15; x <= 15; ++x) {
      for (int y = -15; y <= 15; ++y) balls.push_back({Vec3(0.01 * x, 0.01 * y, 0), 0.5 * kPlateM});
    }
    return make_spheres_shape(balls).value();
  }();
  return union_of_balls;
}

ShapePtr bullet_shape(bool mesh) {
  if (!mesh) return make_sphere_shape(kBulletM).value();
  static const ShapePtr shape =
      make_mesh_shape(test::box_mesh(Vec3(0.05, 0.05, 0.05)), {.depth = 1, .preset = TreePreset::Fast}).value();
  return shape;
}

StepInput swept_step(double dt_s) {
  StepInput input = step_of(dt_s);
  input.backtracking = true;
  return input;
}

struct Shot {
  PlateKind plate = PlateKind::Mesh;
  bool mesh_bullet = false;
  double plate_kg = 0;        // 0: static
  Vec3 aim_m = Vec3::Zero();  // where the trajectory crosses the plate's middle plane
  Vec3 direction = -Vec3::UnitZ();
  Vec3 spin = Vec3::Zero();
  double restitution = 0.5;
  double dt_s = 1.0 / 60;
  bool polygons = false;
};

struct Outcome {
  BodyState bullet, plate;
  double energy_before = 0, energy_most = 0;
  Vec3 momentum_change = Vec3::Zero(), angular_change = Vec3::Zero();  // up to the first impact
  std::size_t hits = 0, cut = 0;
  bool passed = false;  // the bullet's centre was behind the plate's at some time
  double plate_m = 0;   // displacement of the plate
};

// Steps until the bullet is well past the plate.
Outcome fire(const Shot& shot) {
  WorldSettings settings;
  settings.executor = ExecutorKind::Serial;
  Stage stage(settings, shot.restitution);
  BodyDefinition plate;
  plate.shape = stage.world.add_shape(plate_shape(shot.plate));
  plate.material = stage.material;
  plate.motion = shot.plate_kg == 0 ? MotionType::Static : MotionType::Dynamic;
  plate.mass_kg = shot.plate_kg;
  const BodyId plate_id = stage.world.add_body(plate).value();
  const Vec3 direction = shot.direction.normalized();
  const Vec3 from = shot.aim_m - 3.217 * direction;
  const BodyId bullet =
      stage.add(stage.world.add_shape(bullet_shape(shot.mesh_bullet)), from, kSpeed * direction, shot.spin);
  StepInput input = swept_step(shot.dt_s);
  input.polygons = shot.polygons;
  Outcome outcome;
  const Conserved before = stage.world.conserved();
  outcome.energy_before = outcome.energy_most = before.kinetic_j;
  for (double time = 0; time < 2 * 3.217 / kSpeed + 3 * shot.dt_s; time += shot.dt_s) {
    const FrameReport report = stage.world.step(input);
    outcome.hits += report.swept_hits;
    if (outcome.hits == report.swept_hits) {
      const Conserved now = stage.world.conserved();
      outcome.momentum_change = now.momentum_ns - before.momentum_ns;
      outcome.angular_change = now.angular_momentum_js - before.angular_momentum_js;
    }
    outcome.cut += report.swept_cut;
    outcome.energy_most = std::max(outcome.energy_most, stage.world.conserved().kinetic_j);
    const BodyState seen = stage.at(plate_id);
    const Vec3 local = seen.orientation.conjugate() * (stage.at(bullet).position_m - seen.position_m);
    // A free plate may rotate once it is far away.
    if (local.z() < 0 && (shot.plate_kg == 0 || local.z() > -0.1) &&
        local.head<2>().cwiseAbs().maxCoeff() < (shot.plate == PlateKind::Balls ? 0.15 : 0.5))
      outcome.passed = true;
  }
  outcome.bullet = stage.at(bullet);
  outcome.plate = stage.at(plate_id);
  outcome.plate_m = outcome.plate.position_m.norm();
  return outcome;
}

TEST(FastBodies, ABulletNeverPassesAPlateWhateverTheStepTheAngleAndThePlace) {
  for (const PlateKind plate : {PlateKind::Mesh, PlateKind::Balls, PlateKind::Plane}) {
    for (const double dt_s : {1e-4, 7.3e-4, 1e-3, 1.0 / 240, 1.0 / 60}) {
      for (const double tilt : {0.0, 0.4, 1.2, 1.5}) {
        for (const Vec3& aim : {Vec3(0, 0, 0), Vec3(0.123, -0.077, 0), Vec3(-0.13, 0.139, 0)}) {
          Shot shot;
          shot.plate = plate;
          shot.dt_s = dt_s;
          shot.aim_m = aim;
          shot.direction = Vec3(std::sin(tilt), 0.2 * std::sin(tilt), -std::cos(tilt));
          const Outcome outcome = fire(shot);
          SCOPED_TRACE("plate " + std::to_string(static_cast<int>(plate)) + " dt " + std::to_string(dt_s) + " tilt " +
                       std::to_string(tilt) + " x " + std::to_string(aim.x()));
          EXPECT_FALSE(outcome.passed);
          EXPECT_GE(outcome.bullet.velocity_mps.z(), plate == PlateKind::Balls ? -kSpeed : 0.0);
          EXPECT_LE(outcome.energy_most, outcome.energy_before * (1 + 1e-12));
          EXPECT_EQ(outcome.cut, 0U);
        }
      }
    }
  }
}

TEST(FastBodies, AHitAnswersLikeTheClosedFormOfOneImpulse) {
  for (const double restitution : {0.0, 0.5, 1.0}) {
    for (const double tilt : {0.0, 1.0}) {
      Shot shot;
      shot.restitution = restitution;
      shot.direction = Vec3(std::sin(tilt), 0, -std::cos(tilt));
      const Outcome outcome = fire(shot);
      EXPECT_EQ(outcome.hits, 1U);
      const Vec3 expected(kSpeed * std::sin(tilt), 0, restitution * kSpeed * std::cos(tilt));
      EXPECT_LT((outcome.bullet.velocity_mps - expected).norm(), 1e-9 * kSpeed)
          << outcome.bullet.velocity_mps.transpose();
    }
  }
}

TEST(FastBodies, AFreePlateTakesTheMomentumAndNothingIsGained) {
  for (const PlateKind plate : {PlateKind::Mesh, PlateKind::Balls}) {
    for (const double mass : {0.01, 0.5, 20.0}) {
      for (const double restitution : {0.0, 1.0}) {
        for (const double dt_s : {1e-4, 1e-3, 1.0 / 60}) {
          Shot shot;
          shot.plate = plate;
          shot.plate_kg = mass;
          shot.restitution = restitution;
          shot.dt_s = dt_s;
          shot.aim_m = Vec3(0.071, -0.03, 0);
          shot.direction = Vec3(0.3, 0.1, -1);
          const Outcome outcome = fire(shot);
          SCOPED_TRACE("mass " + std::to_string(mass) + " e " + std::to_string(restitution) + " dt " +
                       std::to_string(dt_s) + " plate " + std::to_string(static_cast<int>(plate)));
          const double momentum = 0.0654498 * kSpeed;
          EXPECT_GE(outcome.hits, dt_s < 2e-4 ? 0U : 1U);
          EXPECT_FALSE(outcome.passed);
          EXPECT_LT(outcome.momentum_change.norm(), 1e-9 * momentum);
          EXPECT_LT(outcome.angular_change.norm(), 1e-9 * momentum);
          EXPECT_LE(outcome.energy_most, outcome.energy_before * (1 + 1e-11));
        }
      }
    }
  }
}

TEST(FastBodies, WhatFliesPastTheRimIsNotHit) {
  for (const double gap_m : {2e-4, 0.01}) {
    for (const double side : {-1.0, 1.0}) {
      Shot shot;
      shot.aim_m = Vec3(side * (0.5 + kBulletM + gap_m), 0.2, 0);
      const Outcome past = fire(shot);
      EXPECT_EQ(past.hits, 0U);
      EXPECT_EQ(past.bullet.velocity_mps, Vec3(0, 0, -kSpeed));
      shot.aim_m.x() = side * (0.5 + kBulletM - gap_m);
      EXPECT_EQ(fire(shot).hits, 1U);
    }
  }
}

TEST(FastBodies, AMeshBulletTurnsAsItLikesAndNeverPasses) {
  for (const PlateKind plate : {PlateKind::Mesh, PlateKind::Balls, PlateKind::Plane}) {
    for (const double dt_s : {1e-3, 1.0 / 60}) {
      for (const double spin : {0.0, 30.0, 2000.0}) {
        for (const bool polygons : {false, true}) {
          Shot shot;
          shot.plate = plate;
          shot.mesh_bullet = true;
          shot.dt_s = dt_s;
          shot.spin = spin * Vec3(0.3, 0.5, 0.8);
          shot.polygons = polygons;
          shot.direction = Vec3(0.3, 0, -1);
          const Outcome outcome = fire(shot);
          SCOPED_TRACE("plate " + std::to_string(static_cast<int>(plate)) + " dt " + std::to_string(dt_s) + " spin " +
                       std::to_string(spin) + (polygons ? " polygons" : ""));
          EXPECT_GE(outcome.hits, 1U);
          EXPECT_FALSE(outcome.passed);
          EXPECT_LE(outcome.energy_most, outcome.energy_before * (1 + 1e-9));
        }
      }
    }
  }
}

TEST(FastBodies, AFaceThatLandsFlatIsMetInItsMiddle) {
  for (const PlateKind plate : {PlateKind::Mesh, PlateKind::Plane}) {
    Shot shot;
    shot.plate = plate;
    shot.mesh_bullet = true;
    shot.aim_m = Vec3(0.05, 0.02, 0);
    const Outcome outcome = fire(shot);
    EXPECT_EQ(outcome.hits, 1U);
    EXPECT_LT((outcome.bullet.velocity_mps - Vec3(0, 0, 0.5 * kSpeed)).norm(), 1e-3 * kSpeed)
        << outcome.bullet.velocity_mps.transpose();
    EXPECT_LT(outcome.bullet.angular_velocity_radps.norm() * kBulletM, 1e-2 * kSpeed);
  }
}

TEST(FastBodies, OfSeveralPlatesOneBehindTheOtherTheFirstIsHit) {
  for (const double dt_s : {1e-3, 1.0 / 60}) {
    Stage stage(WorldSettings{}, 0.0);
    const ShapeId plate = stage.world.add_shape(plate_shape(PlateKind::Mesh));
    std::vector<BodyId> plates;
    for (int i = 0; i < 5; ++i) plates.push_back(stage.add(plate, Vec3(0, 0, -0.05 * i)));
    const BodyId bullet = stage.add(stage.ball(kBulletM), Vec3(0.01, 0, 2), Vec3(0, 0, -kSpeed));
    std::vector<double> last(plates.size() + 1, 0);
    bool ordered = true;
    for (int frame = 0; frame < static_cast<int>(0.5 / dt_s); ++frame) {
      stage.world.step(swept_step(dt_s));
      // Above the plate, by the normal of this: what has been hit beside its middle turns.
      Vec3 above_m = stage.at(bullet).position_m;
      for (const BodyId id : plates) {
        const BodyState plate_now = stage.at(id);
        const Vec3 normal = plate_now.orientation * Vec3::UnitZ();
        ordered = ordered && normal.dot(above_m - plate_now.position_m) > 0;
        above_m = plate_now.position_m;
      }
    }
    EXPECT_TRUE(ordered) << dt_s;
    EXPECT_LT(stage.at(plates.back()).velocity_mps.z(), -0.1) << "nothing came through to the last plate";
  }
}

TEST(FastBodies, BulletsThatFlyAtEachOtherMeetHalfWay) {
  Stage stage(WorldSettings{}, 1.0);
  const ShapeId ball = stage.ball(kBulletM);
  const BodyId left = stage.add(ball, Vec3(-2, 0, 0), Vec3(kSpeed, 0, 0));
  const BodyId right = stage.add(ball, Vec3(2, 0, 0), Vec3(-kSpeed, 0, 0));
  const FrameReport report = stage.world.step(swept_step(1.0 / 60));
  EXPECT_EQ(report.swept_pairs, 1U);
  EXPECT_EQ(report.swept_hits, 1U);
  EXPECT_NEAR(stage.at(left).position_m.x(), -kBulletM, 1e-4);
  EXPECT_NEAR(stage.at(right).position_m.x(), kBulletM, 1e-4);
  EXPECT_NEAR(stage.at(left).velocity_mps.x(), -kSpeed, 1e-9);
  ASSERT_EQ(stage.world.contacts().size(), 1U);
  EXPECT_NEAR(stage.world.contacts()[0].impulse_ns.x(), 2 * kSpeed * stage.world.mass_kg(left).value(), 1e-6);
  ASSERT_EQ(stage.world.contact_events().size(), 1U);
  EXPECT_EQ(stage.world.contact_events()[0].kind, ContactEvent::Kind::Begin);
}

TEST(FastBodies, ABodyThatWasHitIsInTheWayOfTheNextBullet) {
  // The second bullet reaches the point where the first one and the ball are at that time.
  Stage stage(WorldSettings{}, 0.0);
  const ShapeId ball = stage.ball(kBulletM);
  const BodyId target = stage.add(ball, Vec3(0, 0, 0));
  stage.add(ball, Vec3(-1, 0, 0), Vec3(kSpeed, 0, 0));
  const BodyId second = stage.add(ball, Vec3(-2, 0, 0), Vec3(kSpeed, 0, 0));
  const FrameReport report = stage.world.step(swept_step(1.0 / 60));
  EXPECT_EQ(report.swept_hits, 2U);
  EXPECT_LT(stage.at(second).position_m.x(), -3.9 * kBulletM);
  EXPECT_LT(stage.at(target).position_m.norm(), 1e-6);
}

// A tray with a small pile, and bullets from one side.
struct Volley {
  Stage stage;
  explicit Volley(int threads, int bullets, ExecutorKind executor = ExecutorKind::Threads)
      : stage(settings_of(threads, executor), 0.3) {
    stage.jacks(40, 6);
    const ShapeId ball = stage.ball(kBulletM);
    for (int i = 0; i < bullets; ++i) {
      stage.add(ball, Vec3(-2.9 + 0.11 * (i % 7), -2 + 0.002 * i, 0.4 + 0.13 * (i % 11)),
                Vec3(kSpeed, 3.0 * (i % 5), -2.0 * (i % 3)));
    }
  }
  static WorldSettings settings_of(int threads, ExecutorKind executor) {
    WorldSettings settings;
    settings.gravity_mps2 = Vec3(0, 0, -9.81);
    settings.threads = threads;
    settings.executor = executor;
    return settings;
  }
};

TEST(FastBodies, AVolleyIntoAPileGainsNothingStaysInTheTrayAndIsTheSameOnAnyThreads) {
  Volley one(1, 400);
  Volley three(3, 400);
  const Conserved before = one.stage.world.conserved();
  std::size_t hits = 0;
  for (int frame = 0; frame < 25; ++frame) {
    hits += one.stage.world.step(swept_step(1.0 / 60)).swept_hits;
    three.stage.world.step(swept_step(1.0 / 60));
    ASSERT_EQ(one.stage.world.state_hash(), three.stage.world.state_hash()) << frame;
  }
  EXPECT_GT(hits, 400U);
  const Conserved after = one.stage.world.conserved();
  EXPECT_LT(after.kinetic_j + after.potential_j, before.kinetic_j + before.potential_j);
  for (const BodyId body : one.stage.bodies) {
    const Vec3 at = one.stage.at(body).position_m;
    EXPECT_LT(std::abs(at.x()), 3.2) << at.transpose();
    EXPECT_LT(std::abs(at.y()), 3.2) << at.transpose();
    EXPECT_GT(at.z(), -0.2) << at.transpose();
  }
}

TEST(FastBodies, OffNothingOfItHappens) {
  Volley off(1, 60);
  Volley slow_on(1, 0);
  Volley slow_off(1, 0);
  for (int frame = 0; frame < 20; ++frame) {
    const FrameReport report = off.stage.world.step(step_of(1.0 / 60));
    EXPECT_EQ(report.swept_pairs + report.swept_hits + report.swept_cut, 0U);
    slow_off.stage.world.step(step_of(1.0 / 60));
    EXPECT_EQ(slow_on.stage.world.step(swept_step(1.0 / 60)).swept_pairs, 0U);
    ASSERT_EQ(slow_on.stage.world.state_hash(), slow_off.stage.world.state_hash()) << "slow bodies go other ways";
  }
}

TEST(FastBodies, WhatAForceMakesFastInItsVeryStepIsStopped) {
  for (const double speed : {20.0, 100.0, 800.0}) {
    Stage stage(one_thread_with_gravity(), 0.0);
    BodyDefinition plate;
    plate.shape = stage.world.add_shape(plate_shape(PlateKind::Mesh));
    plate.material = stage.material;
    plate.motion = MotionType::Static;
    ASSERT_TRUE(stage.world.add_body(plate).ok());
    const BodyId ball = stage.add(stage.ball(kBulletM), Vec3(0.01, 0.02, 0.1));
    const double kg = stage.world.mass_kg(ball).value();
    ASSERT_TRUE(stage.world.apply_force(ball, Vec3(0, 0, -speed * 60 * kg), stage.at(ball).position_m).ok());
    for (int frame = 0; frame < 3; ++frame) stage.world.step(swept_step(1.0 / 60));
    EXPECT_GT(stage.at(ball).position_m.z(), 0) << speed;
  }
}

// What lies on something lies in it by a hair, and its pair is an ordinary one then, whose margin says nothing of its
// speed.
TEST(FastBodies, WhatOverlapsAtTheStartReboundsAndNeverPasses) {
  for (const double restitution : {0.0, 0.3, 1.0}) {
    for (const bool mesh : {false, true}) {
      Stage stage(one_thread_with_gravity(), restitution);
      stage.plane(Vec3::UnitZ(), 0);
      const ShapeId shape = stage.world.add_shape(bullet_shape(mesh));
      const BodyId flat = stage.add(shape, Vec3(0, 0, kBulletM - 1e-5), Vec3(30, 0, -20));
      StepInput input = swept_step(1.0 / 60);
      input.polygons = mesh;
      stage.world.step(input);
      EXPECT_NEAR(stage.at(flat).velocity_mps.z(), 20 * restitution, 0.2) << restitution;
      for (int frame = 0; frame < 30; ++frame) stage.world.step(input);
      EXPECT_GT(stage.at(flat).position_m.z(), 0) << restitution;
    }
  }
  WorldSettings settings;
  settings.executor = ExecutorKind::Serial;
  Stage stage(settings, 1.0);
  const BodyId thrown = stage.add(stage.ball(0.1), Vec3(-0.2, 0, 0), Vec3(50, 0, 0));
  const BodyId rests = stage.add(stage.ball(0.1), Vec3::Zero());
  stage.world.step(swept_step(1.0 / 60));
  EXPECT_NEAR(stage.at(thrown).velocity_mps.x(), 0, 1e-9);
  EXPECT_NEAR(stage.at(rests).velocity_mps.x(), 50, 1e-9);
}

// Each model answers a pair that touches at the start by its one exact contact.
TEST(FastBodies, AFastBallOffTheMiddleOfABoxLeavesStraightUpWithAnyModel) {
  const ShapePtr box =
      make_mesh_shape(test::box_mesh(Vec3(2, 2, 0.4)), {.depth = 2, .preset = TreePreset::Fast}).value();
  for (const ContactModel model : {ContactModel::Paper, ContactModel::Wrench, ContactModel::Fitted}) {
    WorldSettings settings;
    settings.executor = ExecutorKind::Serial;
    settings.contact = model;
    Stage stage(settings, 1.0);
    BodyDefinition body;
    body.shape = stage.world.add_shape(box);
    body.material = stage.material;
    body.motion = MotionType::Static;
    ASSERT_TRUE(stage.world.add_body(body).ok());
    const BodyId ball = stage.add(stage.ball(0.1), Vec3(0.3, 0.1, 0.30001), Vec3(0, 0, -50));
    // Meshes too, which fall on it with a face.
    const BodyId cube = stage.add(stage.world.add_shape(bullet_shape(true)), Vec3(-0.5, 0, 0.22501), Vec3(0, 0, -60));
    for (int frame = 0; frame < 3; ++frame) stage.world.step(swept_step(1.0 / 60));
    EXPECT_LT((stage.at(ball).velocity_mps - Vec3(0, 0, 50)).norm(), 1e-6) << static_cast<int>(model);
    EXPECT_GT(stage.at(cube).velocity_mps.z(), 40) << static_cast<int>(model);
  }
}

// After a hit by a corner the others still come down, and the plate is within the tolerance of the one that was hit.
TEST(FastBodies, ABoxThatTurnsOnItsCornerGoesOnAndGainsNothing) {
  const ShapePtr box =
      make_mesh_shape(test::box_mesh(Vec3(1, 0.1, 0.1)), {.depth = 2, .preset = TreePreset::Fast}).value();
  const ShapePtr wide =
      make_mesh_shape(test::box_mesh(Vec3(8, 8, 0.02)), {.depth = 2, .preset = TreePreset::Fast}).value();
  for (const double speed : {20.0, 60.0}) {
    Stage stage(one_thread_with_gravity(), 0.5);
    BodyDefinition plate;
    plate.shape = stage.world.add_shape(wide);
    plate.material = stage.material;
    plate.motion = MotionType::Static;
    ASSERT_TRUE(stage.world.add_body(plate).ok());
    const BodyId thrown = stage.add(stage.world.add_shape(box), Vec3(0.3, 0.2, 2), Vec3(0, 0, -speed),
                                    Vec3(0.3, 0.5, 0.2), Quat(1, 0.3, 0.2, 0.1).normalized());
    const auto energy = [&] {
      const Conserved now = stage.world.conserved();
      return now.kinetic_j + now.potential_j;
    };
    const double before = energy();
    StepInput input = swept_step(1.0 / 60);
    input.polygons = true;
    std::size_t cut = 0;
    for (int frame = 0; frame < 120; ++frame) {
      cut += stage.world.step(input).swept_cut;
      ASSERT_LE(energy(), before * (1 + 1e-9)) << speed << ", frame " << frame;
      ASSERT_GT(stage.at(thrown).position_m.z(), -0.1) << speed << ", frame " << frame;
    }
    EXPECT_EQ(cut, 0U) << speed;
  }
}

TEST(FastBodies, GravityAndTheRestOfTheStepCostNoEnergyWithoutAHitAndGainNoneWithOne) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 1.0);
  stage.plane(Vec3::UnitZ(), 0);
  stage.plane(-Vec3::UnitZ(), -7);
  stage.add(stage.ball(kBulletM), Vec3(0, 0, 3), Vec3(40, 0, -kSpeed));
  const auto energy = [&] {
    const Conserved now = stage.world.conserved();
    return now.kinetic_j + now.potential_j;
  };
  const double before = energy();
  std::size_t hits = 0;
  for (int frame = 0; frame < 600; ++frame) {
    hits += stage.world.step(swept_step(1.0 / 60)).swept_hits;
    ASSERT_LE(energy(), before * (1 + 1e-12));
  }
  EXPECT_GT(hits, 300U);
  EXPECT_GT(energy(), before * (1 - 1e-3));
}

}  // namespace
}  // namespace poise
