// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "frame/scenes.h"

namespace poise {
namespace {

TEST(TwoBalls, HeadOnAndObliqueFollowTheClosedFormForAnyRestitution) {
  for (const double e : {0.0, 0.3, 0.8, 1.0}) {
    for (const double offset_m : {0.0, 0.4, 0.9}) {
      for (const ContactModel model : {ContactModel::Wrench, ContactModel::Paper, ContactModel::Fitted}) {
        WorldSettings settings;
        settings.contact = model;
        Stage stage(settings, e);
        // Just touching, so that the normal of the impact is known.
        const Vec3 between(std::sqrt(1 - offset_m * offset_m), offset_m, 0);
        const BodyId a = stage.add(stage.ball(0.3), Vec3::Zero(), Vec3(2, 0.5, 0));
        const BodyId b = stage.add(stage.ball(0.7), between * (1 - 1e-9), Vec3(-1, 0, 0.25));
        const double ma = stage.world.mass_kg(a).value();
        const double mb = stage.world.mass_kg(b).value();
        const Vec3 n = between.normalized();
        const double closing = n.dot(Vec3(3, 0.5, -0.25));
        const double impulse = closing > 0 ? (1 + e) * closing / (1 / ma + 1 / mb) : 0;
        stage.world.step(step_of(1e-4));
        const Vec3 va = Vec3(2, 0.5, 0) - impulse / ma * n;
        const Vec3 vb = Vec3(-1, 0, 0.25) + impulse / mb * n;
        EXPECT_LT((stage.at(a).velocity_mps - va).norm(), 1e-12 * va.norm());
        EXPECT_LT((stage.at(b).velocity_mps - vb).norm(), 1e-12 * vb.norm());
        EXPECT_TRUE(stage.at(a).angular_velocity_radps.isZero(1e-12)) << "no friction turns a ball";
      }
    }
  }
}

TEST(OffCentreBody, OnAPlaneTurnsByTheClosedForm) {
  // Two balls of unequal size as one body, which lands on the smaller one.
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const ContactModel model : {ContactModel::Wrench, ContactModel::Paper, ContactModel::Fitted}) {
      WorldSettings settings;
      settings.contact = model;
      Stage stage(settings, e);
      stage.plane(Vec3::UnitZ(), 0);
      const Sphere parts[] = {{Vec3(-1, 0, 0.3), 0.4}, {Vec3(1, 0, -0.3), 0.25}};
      const ShapePtr shape = make_spheres_shape(parts).value();
      const ShapeId id = stage.world.add_shape(shape);
      const BodyId body = stage.add(id, Vec3(0, 0, 0.55 - 1e-6), Vec3(0.2, 0, -3));
      const double mass = stage.world.mass_kg(body).value();
      const Mat3 axes = shape->principal_axes.toRotationMatrix();
      const Mat3 inertia = 1000 * axes * shape->principal_m5.asDiagonal() * axes.transpose();
      const Vec3 arm = Vec3(1, 0, -0.3) - shape->origin_offset_m - Vec3(0, 0, 0.25);
      const Vec3 n = -Vec3::UnitZ();
      const Vec3 turn = inertia.inverse() * arm.cross(n);
      const double k = 1 / mass + n.dot(turn.cross(arm));
      const double impulse = (1 + e) * 3 / k;
      stage.world.step(step_of(1e-5));
      const Vec3 v = Vec3(0.2, 0, -3) - impulse / mass * n;
      const Vec3 w = -impulse * turn;
      EXPECT_LT((stage.at(body).velocity_mps - v).norm(), 1e-6 * v.norm()) << "rounding of the tree to floats";
      EXPECT_LT((stage.at(body).angular_velocity_radps - w).norm(), 1e-4 * w.norm());
    }
  }
}

// Jacks flying toward each other without gravity, at a fixed level.
Stage colliding_jacks(ContactModel model, double restitution) {
  WorldSettings settings;
  settings.contact = model;
  Stage stage(settings, restitution);
  const ShapeId jack = stage.jack();
  std::mt19937_64 random(21);
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-53 - 0.5; };
  for (int i = 0; i < 27; ++i) {
    const Vec3 place(i % 3 - 1, (i / 3) % 3 - 1, i / 9 - 1);
    stage.add(jack, 1.9 * place, -1.5 * place + 0.5 * Vec3(unit(), unit(), unit()), 4 * Vec3(unit(), unit(), unit()),
              Quat(unit(), unit(), unit(), unit()));
  }
  return stage;
}

struct Sums {
  double momentum = 0, angular = 0;  // sums of absolute values, as the scale of errors
};

Sums sizes(const Stage& stage) {
  Sums sums;
  for (const BodyId body : stage.bodies) {
    const BodyState state = stage.at(body);
    const double mass = stage.world.mass_kg(body).value();
    sums.momentum += mass * state.velocity_mps.norm();
    sums.angular +=
        mass * state.position_m.cross(state.velocity_mps).norm() + 0.2 * mass * state.angular_velocity_radps.norm();
  }
  return sums;
}

TEST(Conservation, ElasticImpactsKeepMomentumAngularMomentumAndEnergyAtEveryLevel) {
  for (const ContactModel model : {ContactModel::Wrench, ContactModel::Paper, ContactModel::Fitted}) {
    for (Level level = 0; level <= 2; ++level) {
      Stage stage = colliding_jacks(model, 1);
      const Conserved before = stage.world.conserved();
      const Sums size = sizes(stage);
      StepInput input = step_of(1.0 / 120);
      input.max_level = level;
      std::size_t contacts = 0;
      for (int i = 0; i < 150; ++i) contacts += stage.world.step(input).contact_pairs;
      const Conserved after = stage.world.conserved();
      EXPECT_GT(contacts, 50U);
      EXPECT_LT((after.momentum_ns - before.momentum_ns).norm(), 1e-12 * size.momentum);
      EXPECT_LT((after.angular_momentum_js - before.angular_momentum_js).norm(), 1e-12 * size.angular);
      EXPECT_NEAR(after.kinetic_j, before.kinetic_j, 1e-12 * before.kinetic_j);
    }
  }
}

TEST(Conservation, InelasticImpactsKeepMomentumAndNeverAddEnergyAtEveryLevel) {
  for (const ContactModel model : {ContactModel::Wrench, ContactModel::Paper, ContactModel::Fitted}) {
    for (const double e : {0.0, 0.5}) {
      for (Level level = 0; level <= 2; ++level) {
        Stage stage = colliding_jacks(model, e);
        const Conserved before = stage.world.conserved();
        const Sums size = sizes(stage);
        StepInput input = step_of(1.0 / 120);
        input.max_level = level;
        double energy = before.kinetic_j;
        for (int i = 0; i < 150; ++i) {
          stage.world.step(input);
          const double now = stage.world.conserved().kinetic_j;
          EXPECT_LE(now, energy * (1 + 1e-12));
          energy = now;
        }
        const Conserved after = stage.world.conserved();
        EXPECT_LT(after.kinetic_j, 0.95 * before.kinetic_j);
        EXPECT_LT((after.momentum_ns - before.momentum_ns).norm(), 1e-12 * size.momentum);
      }
    }
  }
}

TEST(Conservation, TheReportOfAFrameHasEnergyAndMomentumAfterItWhereAskedFor) {
  Stage stage = colliding_jacks(ContactModel::Fitted, 0.5);
  StepInput input = step_of(1.0 / 120);
  EXPECT_EQ(stage.world.step(input).momentum_ns, Vec3::Zero()) << "nobody asked";
  input.measure_energy = true;
  const FrameReport report = stage.world.step(input);
  const Conserved after = stage.world.conserved();
  EXPECT_GT(after.momentum_ns.norm(), 0);
  EXPECT_EQ(report.momentum_ns, after.momentum_ns);
  EXPECT_EQ(report.kinetic_j, after.kinetic_j);
}

TEST(Flight, IsExactForConstantGravity) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings);
  const BodyId ball = stage.add(stage.ball(0.1), Vec3(0, 0, 100), Vec3(3, 0, 5));
  for (int i = 0; i < 100; ++i) stage.world.step(step_of(0.02));
  EXPECT_NEAR(stage.at(ball).position_m.z(), 100 + 5 * 2.0 - 0.5 * 9.81 * 4, 1e-11);
  EXPECT_NEAR(stage.at(ball).position_m.x(), 6, 1e-12);
}

TEST(Bounce, AnElasticBallKeepsItsEnergyOverManyBounces) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 1);
  stage.plane(Vec3::UnitZ(), 0);
  stage.add(stage.ball(0.1), Vec3(0, 0, 5));
  const Conserved start = stage.world.conserved();
  for (int i = 0; i < 2000; ++i) {
    stage.world.step(step_of(0.01));
    const Conserved now = stage.world.conserved();
    ASSERT_NEAR(now.kinetic_j + now.potential_j, start.potential_j, 1e-10 * start.potential_j);
  }
}

TEST(Bounce, ADroppedBallComesToRestWhenTheClosedFormSays) {
  // From 1 m with e = 0.5: sqrt(2 h / g) (1 + e) / (1 - e) = 1.3546 s.
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0.5);
  stage.plane(Vec3::UnitZ(), 0);
  const BodyId ball = stage.add(stage.ball(0.1), Vec3(0, 0, 1.1));
  double rest_s = 0;
  for (int i = 1; i <= 2000; ++i) {
    stage.world.step(step_of(1e-3));
    if (stage.at(ball).velocity_mps.norm() > 0.005) rest_s = i * 1e-3;
  }
  EXPECT_NEAR(rest_s, 1.3546, 0.0135);
  EXPECT_NEAR(stage.at(ball).position_m.z(), 0.1, 1e-3);
}

// Added up in parts, which threads share.
TEST(ConservedSums, OfManyBodiesAreTheSameOnAnyNumberOfThreads) {
  std::vector<Conserved> sums;
  for (const int threads : {1, 3}) {
    WorldSettings settings;
    settings.gravity_mps2 = Vec3(0, 0, -9.81);
    settings.threads = threads;
    Stage stage(settings, 0.2);
    const ShapeId ball = stage.ball(0.1);
    for (int i = 0; i < 6000; ++i) {
      stage.add(ball, Vec3(i % 80, i / 80, 1.0 + 0.001 * i));
      ASSERT_TRUE(stage.world.set_velocity(stage.bodies.back(), Vec3(0.1, 0.01 * i, 0), Vec3::UnitZ()).ok());
    }
    sums.push_back(stage.world.conserved());
    double kinetic_j = 0;
    double height_m = 0;
    for (const BodyId body : stage.bodies) {
      kinetic_j += stage.at(body).velocity_mps.squaredNorm();
      height_m += stage.at(body).position_m.z();
    }
    // All have the same mass, and turn at 1 rad/s: I = 0.4 m r^2.
    const double mass_kg = sums.back().momentum_ns.x() / (0.1 * 6000);
    EXPECT_NEAR(sums.back().potential_j, mass_kg * 9.81 * height_m, 1e-9 * sums.back().potential_j);
    EXPECT_NEAR(sums.back().kinetic_j, 0.5 * mass_kg * (kinetic_j + 6000 * 0.4 * 0.01), 1e-9 * sums.back().kinetic_j);
  }
  EXPECT_EQ(sums[0].momentum_ns, sums[1].momentum_ns);
  EXPECT_EQ(sums[0].angular_momentum_js, sums[1].angular_momentum_js);
  EXPECT_EQ(sums[0].kinetic_j, sums[1].kinetic_j);
  EXPECT_EQ(sums[0].potential_j, sums[1].potential_j);
}

}  // namespace
}  // namespace poise
