// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "frame/contact_points.h"
#include "frame/scenes.h"
#include "geometry/meshes.h"

namespace poise {
namespace {

constexpr double kStepS = 1.0 / 60;

WorldSettings on_earth() {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.executor = ExecutorKind::Serial;
  return settings;
}

Vec3 sum_of(const Contact& contact) {
  Vec3 sum = Vec3::Zero();
  for (const ContactPoint& point : contact.points()) sum += point.impulse_ns;
  return sum;
}

TEST(ContactPoints, OfARestingBoxAreItsCornersAndBearItsWeight) {
  Stage stage(on_earth(), 0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId shape = stage.world.add_shape(
      make_mesh_shape(test::box_mesh(Vec3(1, 0.8, 0.6)), {.depth = 2, .preset = TreePreset::Fast}).value());
  const BodyId box = stage.add(shape, Vec3(2, 3, 0.3));
  StepInput input = step_of(kStepS);
  input.polygons = true;
  for (int frame = 0; frame < 120; ++frame) stage.world.step(input);
  ASSERT_EQ(stage.world.contacts().size(), 1U);
  const Contact& contact = stage.world.contacts()[0];
  ASSERT_EQ(contact.points().size(), 4U);
  const double weight_ns = stage.world.mass_kg(box).value() * 9.81 * kStepS;
  EXPECT_LT((sum_of(contact) - contact.impulse_ns).norm(), 1e-12 * weight_ns);
  EXPECT_LT((sum_of(contact) - Vec3(0, 0, weight_ns)).norm(), 0.01 * weight_ns);
  Vec3 torque = Vec3::Zero();
  for (const ContactPoint& point : contact.points()) {
    EXPECT_NEAR(std::abs(point.point_m.x() - 2), 0.5, 0.01);
    EXPECT_NEAR(std::abs(point.point_m.y() - 3), 0.4, 0.01);
    EXPECT_NEAR(point.point_m.z(), 0, 2e-3);
    EXPECT_NEAR(point.separation_m, 0, 2e-3);
    EXPECT_GT(point.normal.z(), 0.999);
    EXPECT_GE(point.impulse_ns.z(), 0);
    torque += (point.point_m - stage.at(box).position_m).cross(point.impulse_ns);
  }
  EXPECT_LT(torque.norm(), 0.02 * weight_ns) << "it does not turn";
}

TEST(ContactPoints, OfABallIsOne) {
  Stage stage(on_earth(), 0);
  stage.plane(Vec3::UnitZ(), 0);
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(0, 0, 0.5));
  for (int frame = 0; frame < 60; ++frame) stage.world.step(step_of(kStepS));
  ASSERT_EQ(stage.world.contacts().size(), 1U);
  const Contact& contact = stage.world.contacts()[0];
  ASSERT_EQ(contact.points().size(), 1U);
  const ContactPoint& point = contact.points()[0];
  EXPECT_LT((point.impulse_ns - contact.impulse_ns).norm(), 1e-12);
  EXPECT_NEAR(point.impulse_ns.z(), stage.world.mass_kg(ball).value() * 9.81 * kStepS, 1e-3);
  EXPECT_LT(point.point_m.norm(), 2e-3);
}

TEST(ContactPoints, AddUpToTheImpulseInAPileAndPointAsItDoes) {
  for (const bool backtracking : {false, true}) {
    Stage stage(on_earth());
    stage.jacks(40, 4);
    StepInput input = step_of(kStepS);
    input.backtracking = backtracking;
    std::size_t several = 0;
    for (int frame = 0; frame < 120; ++frame) {
      stage.world.step(input);
      for (const Contact& contact : stage.world.contacts()) {
        ASSERT_GE(contact.points().size(), 1U);
        EXPECT_LT((sum_of(contact) - contact.impulse_ns).norm(), 1e-9 * (1 + contact.impulse_ns.norm()));
        for (const ContactPoint& point : contact.points()) EXPECT_NEAR(point.normal.norm(), 1, 1e-6);
        several += contact.points().size() > 1 ? 1U : 0U;
      }
    }
    EXPECT_GT(several, 10U);
  }
}

TEST(ContactEvents, TellTheImpulseOfWhatBegins) {
  constexpr double kRestitution = 0.5;
  Stage stage(on_earth(), kRestitution);
  stage.plane(Vec3::UnitZ(), 0);
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(0, 0, 2));
  double before_mps = 0;
  for (int frame = 0; frame < 60 && stage.world.contact_events().empty(); ++frame) {
    before_mps = stage.at(ball).velocity_mps.z();
    stage.world.step(step_of(kStepS));
  }
  ASSERT_EQ(stage.world.contact_events().size(), 1U);
  const ContactEvent& event = stage.world.contact_events()[0];
  EXPECT_EQ(event.kind, ContactEvent::Kind::Begin);
  ASSERT_EQ(stage.world.contacts().size(), 1U);
  EXPECT_EQ(event.impulse_ns, stage.world.contacts()[0].impulse_ns);
  const double expected = (1 + kRestitution) * stage.world.mass_kg(ball).value() * -before_mps;
  EXPECT_NEAR(event.impulse_ns.z(), expected, 1e-6 * expected);
}

TEST(ContactEvents, ThatPersistAreToldOnlyWhenAskedFor) {
  Stage asked(on_earth(), 0.2);
  Stage plain(on_earth(), 0.2);
  asked.jacks(40, 4);
  plain.jacks(40, 4);
  StepInput input = step_of(kStepS);
  StepInput asking = input;
  asking.persist_events = true;
  std::size_t persisted = 0;
  for (int frame = 0; frame < 120; ++frame) {
    plain.world.step(input);
    asked.world.step(asking);
    ASSERT_EQ(plain.world.state_hash(), asked.world.state_hash());
    std::vector<ContactEvent> others;
    std::size_t touching = 0;
    for (const ContactEvent& event : asked.world.contact_events()) {
      const auto contacts = asked.world.contacts();
      const auto at = std::ranges::find_if(
          contacts, [&](const Contact& contact) { return contact.a == event.a && contact.b == event.b; });
      EXPECT_EQ(at != contacts.end(), event.kind != ContactEvent::Kind::End);
      if (at != contacts.end()) {
        EXPECT_EQ(event.impulse_ns, at->impulse_ns);
        ++touching;
      } else {
        EXPECT_TRUE(event.impulse_ns.isZero(0));
      }
      if (event.kind == ContactEvent::Kind::Persist) {
        ++persisted;
      } else {
        others.push_back(event);
      }
    }
    EXPECT_EQ(touching, asked.world.contacts().size()) << "each contact has one event";
    EXPECT_TRUE(std::ranges::is_sorted(asked.world.contact_events(), {},
                                       [](const ContactEvent& e) { return std::pair(e.a.slot, e.b.slot); }));
    const auto same = [](const ContactEvent& x, const ContactEvent& y) {
      return x.kind == y.kind && x.a == y.a && x.b == y.b && x.impulse_ns == y.impulse_ns;
    };
    EXPECT_TRUE(std::ranges::equal(others, plain.world.contact_events(), same));
  }
  EXPECT_GT(persisted, 200U);
}

// Forces that nearly cancel say little of what their pair gave: no point gave more than its force for a step.
TEST(ContactPoints, ThatHoldEachOtherInBalanceAreToldNoMoreThanTheirForces) {
  constexpr double kForceN = 1000;
  simulation::PredictedMotion motion;
  motion.poses.resize(2);
  motion.poses[0] = motion.poses[1] = {};
  simulation::PointCache cache;
  cache.points.resize(3);
  cache.forces.resize(3);
  for (std::size_t k = 0; k < 3; ++k) {
    cache.points[k] = {};
    cache.points[k].normal = k == 1 ? Vec3(Vec3::UnitX()) : Vec3(-Vec3::UnitX());
    cache.forces[k] = {kForceN + (k == 1 ? 1e-6 : 0.0), Vec3::Zero()};
  }
  simulation::ActivePair pair;
  pair.a = 0;
  pair.b = 1;
  const simulation::PairPoints made{simulation::PointCache::slot_at(0, simulation::PointCache::size_for(3)), 3, true};
  Contact contact;
  contact.impulse_ns = Vec3(2, 0, 0);
  simulation::list_points({motion, cache, pair, made, kStepS}, 1, contact);
  ASSERT_EQ(contact.points().size(), 2U);
  EXPECT_LT((sum_of(contact) - contact.impulse_ns).norm(), 1e-12);
  for (const ContactPoint& point : contact.points()) EXPECT_LT(point.impulse_ns.norm(), kForceN * kStepS + 2);
}

// Without gravity all that changes a velocity is a contact.
TEST(ContactPoints, ImpulsesOfContactsAreWhatTheirBodiesReceived) {
  WorldSettings settings;
  settings.executor = ExecutorKind::Serial;
  Stage stage(settings, 0.3);
  std::mt19937_64 random(5);
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-53 - 0.5; };
  const ShapeId jack = stage.jack();
  for (int i = 0; i < 24; ++i) {
    Vec3 place = Vec3::Zero();
    for (double& part : place) part = 5 * unit();
    stage.add(jack, place, -place, Vec3(6 * unit(), 6 * unit(), 6 * unit()));
  }
  std::size_t contacts = 0;
  for (int frame = 0; frame < 120; ++frame) {
    std::vector<Vec3> expected;
    for (const BodyId body : stage.bodies)
      expected.push_back(stage.world.mass_kg(body).value() * stage.at(body).velocity_mps);
    stage.world.step(step_of(kStepS));
    for (const Contact& contact : stage.world.contacts()) {
      expected[contact.a.slot] -= contact.impulse_ns;
      expected[contact.b.slot] += contact.impulse_ns;
      ++contacts;
    }
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const double kg = stage.world.mass_kg(stage.bodies[i]).value();
      EXPECT_LT((kg * stage.at(stage.bodies[i]).velocity_mps - expected[i]).norm(), 1e-9 * kg) << frame;
    }
  }
  EXPECT_GT(contacts, 200U);
}

}  // namespace
}  // namespace poise
