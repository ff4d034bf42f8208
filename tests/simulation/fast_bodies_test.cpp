// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "geometry/meshes.h"
#include "simulation/scenes.h"

namespace poise {
namespace {

constexpr double kBulletM = 0.025;   // radius
constexpr double kPlateM = 0.02;     // thickness
constexpr double kSpeed = 500;

enum class PlateKind { Mesh, Balls, Plane };

ShapePtr plate_shape(PlateKind kind) {
  if (kind == PlateKind::Plane) return make_plane_shape(Vec3::UnitZ(), 0.5 * kPlateM).value();
  if (kind == PlateKind::Mesh) {
    static const ShapePtr shape = make_mesh_shape(test::box_mesh(Vec3(1, 1, kPlateM)), {.depth = 2, .preset = TreePreset::Fast}).value();
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
  double plate_kg = 0;              // 0: static
  Vec3 aim_m = Vec3::Zero();        // where the line of flight crosses the plate's middle
  Vec3 direction = -Vec3::UnitZ();
  Vec3 spin = Vec3::Zero();
  double restitution = 0.5;
  double dt_s = 1.0 / 60;
  bool polygons = false;
};

struct Outcome {
  BodyState bullet, plate;
  double energy_before = 0, energy_most = 0;
  Vec3 momentum_change = Vec3::Zero(), angular_change = Vec3::Zero();  // up to the first hit
  std::size_t hits = 0, cut = 0;
  bool passed = false;              // the bullet's centre was ever behind the plate's
  double plate_m = 0;               // how far the plate came
};

// Flies until well past the plate.
Outcome fire(const Shot& shot) {
  WorldSettings settings;
  settings.executor = ExecutorKind::Serial;
  Stage stage(settings, shot.restitution);
  BodyDefinition plate;
  plate.shape = stage.world.add_shape(plate_shape(shot.plate));
  plate.material = stage.material;
  plate.is_static = shot.plate_kg == 0;
  plate.mass_kg = shot.plate_kg;
  const BodyId plate_id = stage.world.add_body(plate).value();
  const Vec3 direction = shot.direction.normalized();
  const Vec3 from = shot.aim_m - 3.217 * direction;
  const BodyId bullet = stage.add(stage.world.add_shape(bullet_shape(shot.mesh_bullet)), from, kSpeed * direction, shot.spin);
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
    // A free plate may turn over once it is far away.
    if (local.z() < 0 && (shot.plate_kg == 0 || local.z() > -0.1) && local.head<2>().cwiseAbs().maxCoeff() < (shot.plate == PlateKind::Balls ? 0.15 : 0.5)) outcome.passed = true;
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
          SCOPED_TRACE("plate " + std::to_string(static_cast<int>(plate)) + " dt " + std::to_string(dt_s) + " tilt " + std::to_string(tilt) + " x " + std::to_string(aim.x()));
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
      EXPECT_LT((outcome.bullet.velocity_mps - expected).norm(), 1e-9 * kSpeed) << outcome.bullet.velocity_mps.transpose();
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
          SCOPED_TRACE("mass " + std::to_string(mass) + " e " + std::to_string(restitution) + " dt " + std::to_string(dt_s) + " plate " + std::to_string(static_cast<int>(plate)));
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

}  // namespace
}  // namespace poise
