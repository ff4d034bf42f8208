// SPDX-License-Identifier: MIT
#include "poise/world.h"

#include <gtest/gtest.h>

#include <limits>

#include "frame/scenes.h"

namespace poise {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string refusal_of(const auto& result) { return result.ok() ? "(not refused)" : result.error().message; }

TEST(World, RefusesBadSettingsWithFieldAndRule) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, kNan, 0);
  EXPECT_NE(refusal_of(World::create(settings)).find("gravity_mps2"), std::string::npos);
  settings = {};
  settings.substeps = 0;
  EXPECT_EQ(refusal_of(World::create(settings)), "substeps = 0, must be in [1, 16]");
  settings = {};
  settings.threads = 257;
  EXPECT_EQ(refusal_of(World::create(settings)), "threads = 257, must be in [0, 256]");
  settings = {};
  settings.executor = static_cast<ExecutorKind>(77);
  EXPECT_EQ(refusal_of(World::create(settings)), "executor = 77, must be in [0, 3]");
  settings = {};
  settings.contact = static_cast<ContactModel>(3);
  EXPECT_EQ(refusal_of(World::create(settings)), "contact = 3, must be in [0, 2]");
  settings = {};
  settings.islands_wait = static_cast<IslandsWait>(9);
  EXPECT_EQ(refusal_of(World::create(settings)), "islands_wait = 9, must be in [0, 2]");
  settings = {};
  settings.policy.size = -1;
  EXPECT_NE(refusal_of(World::create(settings)).find("policy"), std::string::npos);
}

TEST(World, RefusesBadMaterials) {
  Stage stage({});
  for (const Material& bad : {Material{-0.1, 0, 1}, Material{1.1, 0, 1}, Material{kNan, 0, 1}, Material{0, -1, 1},
                              Material{0, 0, 0}, Material{0, 0, kInfinity}}) {
    EXPECT_FALSE(stage.world.add_material(bad).ok());
  }
}

TEST(World, RefusesEveryKindOfBadBodyAndStaysAsItWas) {
  Stage stage({});
  BodyDefinition good;
  good.shape = stage.ball(0.5);
  good.material = stage.material;
  struct Case {
    const char* says;
    void (*spoil)(BodyDefinition&);
  };
  const Case cases[] = {
      {"no such shape", [](BodyDefinition& b) { b.shape.index = 99; }},
      {"no such material", [](BodyDefinition& b) { b.material.index = 99; }},
      {"position_m", [](BodyDefinition& b) { b.position_m.x() = kNan; }},
      {"position_m", [](BodyDefinition& b) { b.position_m.x() = 1e13; }},
      {"orientation_wxyz", [](BodyDefinition& b) { b.orientation = Quat(0, 0, 0, 0); }},
      {"orientation_wxyz", [](BodyDefinition& b) { b.orientation = Quat(kNan, 0, 0, 1); }},
      {"velocity_mps", [](BodyDefinition& b) { b.velocity_mps.z() = kInfinity; }},
      {"angular_velocity_radps", [](BodyDefinition& b) { b.angular_velocity_radps.y() = 1e10; }},
      {"mass_kg = -1, must be > 0", [](BodyDefinition& b) { b.mass_kg = -1; }},
      {"mass_kg = nan, must be > 0", [](BodyDefinition& b) { b.mass_kg = kNan; }},
      {"mass_kg", [](BodyDefinition& b) { b.mass_kg = kInfinity; }},
      {"each must be finite and > 0", [](BodyDefinition& b) { b.inertia_kgm2 = Vec3(1, 0, 1); }},
      {"triangle inequality", [](BodyDefinition& b) { b.inertia_kgm2 = Vec3(1, 1, 2.1); }},
      {"the square of the bounding radius", [](BodyDefinition& b) { b.inertia_kgm2 = Vec3(1, 1, 1e-13); }},
      {"importance", [](BodyDefinition& b) { b.importance = -1; }},
      {"must be at rest",
       [](BodyDefinition& b) {
         b.motion = MotionType::Static;
         b.velocity_mps.x() = 1;
       }},
  };
  const std::uint64_t before = stage.world.state_hash();
  for (const Case& bad : cases) {
    BodyDefinition body = good;
    bad.spoil(body);
    EXPECT_NE(refusal_of(stage.world.add_body(body)).find(bad.says), std::string::npos)
        << refusal_of(stage.world.add_body(body)) << " should say " << bad.says;
    EXPECT_EQ(refusal_of(stage.world.check_body(body)), refusal_of(stage.world.add_body(body)));
  }
  EXPECT_TRUE(stage.world.check_body(good).ok());
  EXPECT_EQ(stage.world.state_hash(), before);
  BodyDefinition plane = good;
  plane.shape = stage.world.add_shape(make_plane_shape(Vec3::UnitZ(), 0).value());
  EXPECT_NE(refusal_of(stage.world.add_body(plane)).find("a plane must be static"), std::string::npos);
  BodyDefinition shapeless = good;
  shapeless.shape = stage.world.add_shape(nullptr);
  EXPECT_NE(refusal_of(stage.world.add_body(shapeless)).find("no such shape"), std::string::npos);
  EXPECT_FALSE(stage.world.add_body(BodyDefinition{}).ok());
  EXPECT_EQ(stage.world.body_count(), 0U);
}

TEST(World, RefusesBadStatesForcesAndImpulses) {
  Stage stage({});
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(1, 2, 3));
  const std::uint64_t hash = stage.world.state_hash();
  BodyState state = stage.at(ball);
  state.velocity_mps.x() = kNan;
  EXPECT_FALSE(stage.world.set_state(ball, state).ok());
  EXPECT_FALSE(stage.world.apply_force(ball, Vec3(kInfinity, 0, 0), Vec3::Zero()).ok());
  EXPECT_FALSE(stage.world.apply_force(ball, Vec3(1, 0, 0), Vec3(kNan, 0, 0)).ok());
  EXPECT_FALSE(stage.world.apply_torque(ball, Vec3(kNan, 0, 0)).ok());
  EXPECT_FALSE(stage.world.apply_impulse(ball, Vec3(kNan, 0, 0), Vec3::Zero()).ok());
  EXPECT_FALSE(stage.world.apply_impulse(ball, Vec3(1e20, 0, 0), Vec3::Zero()).ok()) << "faster than allowed";
  EXPECT_FALSE(stage.world.set_importance(ball, kNan).ok());
  EXPECT_EQ(stage.world.state_hash(), hash);
}

TEST(World, AStateThatIsReadAndSetAgainIsTheSameToTheBit) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0.2);
  stage.jacks(40, 4);
  for (int i = 0; i < 60; ++i) stage.world.step(step_of(1.0 / 60));
  const std::uint64_t hash = stage.world.state_hash();
  for (const BodyId body : stage.bodies) ASSERT_TRUE(stage.world.set_state(body, stage.at(body)).ok());
  EXPECT_EQ(stage.world.state_hash(), hash);
}

TEST(World, RefusesBadSteps) {
  Stage stage({});
  stage.add(stage.ball(0.5), Vec3::Zero(), Vec3(1, 0, 0));
  const std::uint64_t hash = stage.world.state_hash();
  for (const double bad : {0.0, -1.0, 1e4, kNan, kInfinity}) {
    EXPECT_EQ(stage.world.step(step_of(bad)).status, StepStatus::RefusedTimeStep);
  }
  StepInput view = step_of(0.01);
  view.view.present = true;
  view.view.gaze = Vec3::Zero();
  EXPECT_EQ(stage.world.step(view).status, StepStatus::RefusedView);
  StepInput host = step_of(0.01);
  host.host_work.expected = Nanoseconds(-1);
  EXPECT_EQ(stage.world.step(host).status, StepStatus::RefusedHostWork);
  EXPECT_EQ(stage.world.state_hash(), hash);
}

TEST(World, AStaleHandleIsRefusedEverywhere) {
  Stage stage({});
  const ShapeId shape = stage.ball(0.5);
  const BodyId old = stage.add(shape, Vec3::Zero());
  ASSERT_TRUE(stage.world.remove_body(old).ok());
  const BodyId fresh = stage.add(shape, Vec3(9, 0, 0));
  ASSERT_EQ(fresh.slot, old.slot);
  World& world = stage.world;
  EXPECT_EQ(world.state(old).error().kind, ErrorKind::StaleHandle);
  EXPECT_FALSE(world.remove_body(old).ok());
  EXPECT_FALSE(world.set_state(old, BodyState{}).ok());
  EXPECT_FALSE(world.apply_force(old, Vec3::UnitX(), Vec3::Zero()).ok());
  EXPECT_FALSE(world.apply_torque(old, Vec3::UnitX()).ok());
  EXPECT_FALSE(world.apply_impulse(old, Vec3::UnitX(), Vec3::Zero()).ok());
  EXPECT_FALSE(world.set_groups(old, 1, 1).ok());
  EXPECT_FALSE(world.mass_kg(old).ok());
  EXPECT_EQ(stage.at(fresh).position_m, Vec3(9, 0, 0));
}

TEST(World, ABodyInASlotUsedAgainInheritsNoContact) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0);
  const ShapeId shape = stage.ball(0.5);
  stage.plane(Vec3::UnitZ(), 0);
  const BodyId resting = stage.add(shape, Vec3(0, 0, 0.5));
  for (int i = 0; i < 20; ++i) stage.world.step(step_of(0.01));
  ASSERT_EQ(stage.world.contacts().size(), 1U);
  ASSERT_TRUE(stage.world.remove_body(resting).ok());
  stage.add(shape, Vec3(0, 0, 0.5));
  stage.world.step(step_of(0.01));
  ASSERT_EQ(stage.world.contact_events().size(), 2U);
  EXPECT_EQ(stage.world.contact_events()[0].kind, ContactEvent::Kind::End);
  EXPECT_EQ(stage.world.contact_events()[0].b, resting);
  EXPECT_EQ(stage.world.contact_events()[1].kind, ContactEvent::Kind::Begin);
}

TEST(World, MassFollowsDensityUnlessGiven) {
  Stage stage({});
  const BodyId by_density = stage.add(stage.ball(0.5), Vec3::Zero());
  EXPECT_NEAR(stage.world.mass_kg(by_density).value(), 1000 * 4.0 / 3 * 3.14159265358979 * 0.125, 1e-9);
  BodyDefinition given;
  given.shape = stage.ball(1);
  given.material = stage.material;
  given.mass_kg = 7;
  EXPECT_EQ(stage.world.mass_kg(stage.world.add_body(given).value()).value(), 7);
}

TEST(World, ContactsAndEventsTellWhatTouchesAndWhatWasGiven) {
  WorldSettings settings;
  Stage stage(settings, 1);
  const ShapeId shape = stage.ball(0.5);
  const BodyId left = stage.add(shape, Vec3(-0.505, 0, 0), Vec3(1, 0, 0));
  const BodyId right = stage.add(shape, Vec3(0.505, 0, 0), Vec3(-1, 0, 0));
  const double mass = stage.world.mass_kg(left).value();
  int begins = 0;
  int ends = 0;
  Vec3 impulse = Vec3::Zero();
  for (int i = 0; i < 20; ++i) {
    stage.world.step(step_of(0.002));
    for (const ContactEvent& event : stage.world.contact_events()) {
      EXPECT_EQ(event.a, left);
      EXPECT_EQ(event.b, right);
      ++(event.kind == ContactEvent::Kind::Begin ? begins : ends);
    }
    for (const Contact& contact : stage.world.contacts()) {
      EXPECT_TRUE(contact.normal.isApprox(Vec3::UnitX()));
      EXPECT_NEAR(contact.point_m.norm(), 0, 1e-12);
      impulse += contact.impulse_ns;
    }
  }
  EXPECT_EQ(begins, 1);
  EXPECT_EQ(ends, 1);
  EXPECT_NEAR(impulse.x(), 2 * mass, 1e-9 * mass);
}

TEST(World, AContactWithAPlaneInALowerSlotPointsFromThePlane) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  Stage stage(settings, 0);
  const BodyId floor = stage.plane(Vec3::UnitZ(), 0);
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(0, 0, 0.5));
  stage.world.step(step_of(0.01));
  ASSERT_EQ(stage.world.contacts().size(), 1U);
  const Contact& contact = stage.world.contacts()[0];
  EXPECT_EQ(contact.a, floor);
  EXPECT_EQ(contact.b, ball);
  EXPECT_TRUE(contact.normal.isApprox(Vec3::UnitZ()));
  EXPECT_NEAR(contact.impulse_ns.z(), stage.world.mass_kg(ball).value() * 9.81 * 0.01, 1e-5);
}

TEST(World, GroupsThatDoNotMeetPassThroughEachOther) {
  Stage stage({}, 1);
  const ShapeId shape = stage.ball(0.5);
  const BodyId a = stage.add(shape, Vec3(-1, 0, 0), Vec3(1, 0, 0));
  const BodyId b = stage.add(shape, Vec3(1, 0, 0), Vec3(-1, 0, 0));
  ASSERT_TRUE(stage.world.set_groups(a, 1, 1).ok());
  ASSERT_TRUE(stage.world.set_groups(b, 2, 3).ok());
  for (int i = 0; i < 200; ++i) stage.world.step(step_of(0.01));
  EXPECT_EQ(stage.at(a).velocity_mps, Vec3(1, 0, 0));
}

TEST(World, ForcesActForOneStepAndTorquesTurn) {
  Stage stage({});
  BodyDefinition body;
  body.shape = stage.ball(0.5);
  body.material = stage.material;
  body.mass_kg = 2;
  const BodyId ball = stage.world.add_body(body).value();
  ASSERT_TRUE(stage.world.apply_force(ball, Vec3(4, 0, 0), Vec3(0, 0.5, 0)).ok());
  stage.world.step(step_of(0.1));
  const double inertia = 0.4 * 2 * 0.25;
  EXPECT_TRUE(stage.at(ball).velocity_mps.isApprox(Vec3(0.2, 0, 0)));
  EXPECT_NEAR(stage.at(ball).position_m.x(), 0.5 * 2 * 0.01, 1e-15);
  EXPECT_NEAR(stage.at(ball).angular_velocity_radps.z(), -4 * 0.5 / inertia * 0.1, 1e-12);
  stage.world.step(step_of(0.1));
  EXPECT_TRUE(stage.at(ball).velocity_mps.isApprox(Vec3(0.2, 0, 0))) << "the force was cleared";
}

TEST(World, AnImpulseActsAtOnce) {
  Stage stage({});
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(1, 1, 1));
  const double mass = stage.world.mass_kg(ball).value();
  ASSERT_TRUE(stage.world.apply_impulse(ball, Vec3(0, 0, mass), Vec3(1.5, 1, 1)).ok());
  EXPECT_TRUE(stage.at(ball).velocity_mps.isApprox(Vec3(0, 0, 1)));
  EXPECT_NEAR(stage.at(ball).angular_velocity_radps.y(), -0.5 / (0.4 * 0.25), 1e-12);
}

TEST(World, AnEmptyWorldSteps) {
  Stage stage({});
  const FrameReport report = stage.world.step(step_of(0.01));
  EXPECT_EQ(report.status, StepStatus::Done);
  EXPECT_EQ(report.bodies, 0U);
}

}  // namespace
}  // namespace poise
