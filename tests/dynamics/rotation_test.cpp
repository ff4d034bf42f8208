// SPDX-License-Identifier: MIT
#include "dynamics/rotation.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

namespace poise::dynamics {
namespace {

Vec3 momentum(const Rotation& rotation, const Vec3& moments) {
  return rotation.orientation * moments.cwiseProduct(rotation.orientation.conjugate() * rotation.spin_radps);
}

double energy(const Rotation& rotation, const Vec3& moments) {
  return 0.5 * rotation.spin_radps.dot(momentum(rotation, moments));
}

TEST(Rotation, ABallTurnsByTheExactAngle) {
  const Rotation turned = turned_freely({Quat::Identity(), Vec3(0, 0, 3)}, Vec3::Ones(), 0.4);
  const Quat exact(std::cos(0.6), 0, 0, std::sin(0.6));
  EXPECT_LT(turned.orientation.angularDistance(exact), 1e-15);
  EXPECT_EQ(turned.spin_radps, Vec3(0, 0, 3));
}

TEST(Rotation, ASymmetricTopPrecessesAtTheClosedFormRate) {
  // In the body frame the angular velocity rotates about the symmetry axis at (I1 - I3) / I1 * w3.
  const Vec3 moments(2, 2, 1);
  Rotation rotation{Quat::Identity(), Vec3(1, 0, 2)};
  const double time_s = 3;
  for (int i = 0; i < 3000; ++i) rotation = turned_freely(rotation, moments, 1e-3);
  const Vec3 body = rotation.orientation.conjugate() * rotation.spin_radps;
  const double angle = (moments.x() - moments.z()) / moments.x() * 2 * time_s;
  EXPECT_NEAR(body.x(), std::cos(angle), 1e-5);
  EXPECT_NEAR(body.y(), -std::sin(angle), 1e-5);
  EXPECT_NEAR(body.z(), 2, 1e-12);
}

TEST(Rotation, AnAsymmetricTopFlipsOnTime) {
  // I = (1, 2, 3), w = (0.01, 1, 0.01): w_2 changes sign first at 10.916913 s, then every 19.552867 s (Jacobi's
  // functions).
  const Vec3 moments(1, 2, 3);
  Rotation rotation{Quat::Identity(), Vec3(0.01, 1, 0.01)};
  const double h = 1e-3;
  double before = 1;
  std::vector<double> flips_s;
  for (int i = 1; flips_s.size() < 3; ++i) {
    rotation = turned_freely(rotation, moments, h);
    const double now = (rotation.orientation.conjugate() * rotation.spin_radps).y();
    if ((now > 0) != (before > 0)) flips_s.push_back(h * (i - now / (now - before)));
    before = now;
  }
  EXPECT_NEAR(flips_s[0], 10.916913, 1e-4);
  EXPECT_NEAR(flips_s[1], 10.916913 + 19.552867, 2e-4);
  EXPECT_NEAR(flips_s[2], 10.916913 + 2 * 19.552867, 4e-4);
}

RC_GTEST_PROP(Rotation, KeepsEnergyAndAngularMomentum, ()) {
  const auto unit = [] { return 1e-3 * *rc::gen::inRange(1, 1000); };
  // Principal moments of an arbitrary real body: sums of squares of extents.
  const Vec3 extents(unit(), unit(), unit());
  const Vec3 moments(extents.y() + extents.z(), extents.x() + extents.z(), extents.x() + extents.y());
  const double speed = *rc::gen::element(0.1, 1.0, 30.0);
  Rotation rotation{Quat(unit(), unit(), unit(), unit()).normalized(), speed * Vec3(unit(), -unit(), unit())};
  const double h = *rc::gen::element(1e-4, 1e-2, 0.1);
  const Vec3 momentum_before = momentum(rotation, moments);
  const double energy_before = energy(rotation, moments);
  for (int i = 0; i < 200; ++i) rotation = turned_freely(rotation, moments, h);
  RC_ASSERT((momentum(rotation, moments) - momentum_before).norm() < 1e-11 * momentum_before.norm());
  RC_ASSERT(std::abs(energy(rotation, moments) - energy_before) < 1e-11 * energy_before);
}

TEST(Rotation, AnAbsurdSpinStaysFiniteAndKeepsItsMomentum) {
  const Vec3 moments(1, 2, 2.9);
  Rotation rotation{Quat::Identity(), Vec3(3e4, 1e4, -2e4)};
  const Vec3 before = momentum(rotation, moments);
  const double energy_before = energy(rotation, moments);
  for (int i = 0; i < 100; ++i) rotation = turned_freely(rotation, moments, 1.0 / 60);
  EXPECT_TRUE(rotation.spin_radps.allFinite());
  EXPECT_LT((momentum(rotation, moments) - before).norm(), 1e-11 * before.norm());
  EXPECT_LT(energy(rotation, moments), 3 * energy_before);
}

TEST(TurnedBy, KeepsAngularMomentumAndNeverAddsEnergy) {
  const Vec3 moments(1, 2, 3);
  Rotation start;
  start.spin_radps = Vec3(0.3, -2, 1);
  const auto momentum = [&](const Vec3& of, const Rotation& r) {
    return Vec3(r.orientation * of.cwiseProduct(r.orientation.conjugate() * r.spin_radps));
  };
  const auto energy = [&](const Vec3& of, const Rotation& r) { return 0.5 * r.spin_radps.dot(momentum(of, r)); };
  int kept = 0;
  for (const Vec3& tilt : {Vec3(0.01, 0, 0), Vec3(-0.01, 0, 0), Vec3(0, 0.02, 0.01), Vec3(0, -0.02, -0.01)}) {
    const Rotation after = turned_by(start, moments, rotation_by(tilt), TurnKeeps::Turn);
    EXPECT_LE(energy(moments, after), energy(moments, start) * (1 + 1e-14));
    const Vec3 change = momentum(moments, after) - momentum(moments, start);
    kept += change.norm() < 1e-14 ? 1 : 0;
    const Rotation calm = turned_by(start, moments, rotation_by(tilt), TurnKeeps::Momentum);
    EXPECT_LE(energy(moments, calm), energy(moments, start) * (1 + 1e-14));
    EXPECT_LT((momentum(moments, calm) - momentum(moments, start)).norm(), 1e-14) << "all of it stays";
    EXPECT_LT(momentum(moments, after).cross(momentum(moments, start)).norm(), 1e-13)
        << "the direction stays in any case";
  }
  EXPECT_GE(kept, 2);
  // A needle that rotates end over end: tilted, its momentum would otherwise spin it up 75 times.
  const Vec3 needle(1e-4, 1, 1);
  Rotation tumbling;
  tumbling.spin_radps = Vec3(0, 0, 5);
  EXPECT_LE(energy(needle, turned_by(tumbling, needle, rotation_by(Vec3(0, 0.9, 0)), TurnKeeps::Turn)),
            energy(needle, tumbling) * (1 + 1e-14));
}

}  // namespace
}  // namespace poise::dynamics
