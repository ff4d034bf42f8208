// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <limits>

#include "frame/scenes.h"

namespace poise {
namespace {

WorldSettings heavy() {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.threads = 1;
  settings.max_front_entries = 1U << 16U;
  return settings;
}

std::string refusal(const Status& status) { return status ? std::string() : status.error().message; }

TEST(UserData, IsKeptWithABodyAndChangesNothing) {
  Stage one(heavy());
  Stage two(heavy());
  BodyDefinition body;
  body.shape = one.ball(0.5);
  two.ball(0.5);
  body.material = one.material;
  const BodyId plain = two.world.add_body(body).value();
  body.user_data = 0xfedcba9876543210U;
  const BodyId told = one.world.add_body(body).value();
  EXPECT_EQ(one.world.user_data(told).value(), 0xfedcba9876543210U);
  EXPECT_EQ(two.world.user_data(plain).value(), 0U);
  EXPECT_EQ(one.world.state_hash(), two.world.state_hash());
  ASSERT_TRUE(one.world.set_user_data(told, 7));
  EXPECT_EQ(one.world.user_data(told).value(), 7U);
  ASSERT_TRUE(one.world.remove_body(told));
  EXPECT_FALSE(one.world.user_data(told));
  EXPECT_FALSE(one.world.set_user_data(told, 1));
  body.user_data = 0;
  EXPECT_EQ(one.world.user_data(one.world.add_body(body).value()).value(), 0U);  // the slot is reused
}

TEST(Bodies, AreListedInOrderOfSlots) {
  Stage stage(heavy());
  const ShapeId shape = stage.ball(0.5);
  for (int i = 0; i < 5; ++i) stage.add(shape, Vec3(2 * i, 0, 0));
  EXPECT_EQ(stage.world.bodies(), stage.bodies);
  ASSERT_TRUE(stage.world.remove_body(stage.bodies[2]));
  const std::vector<BodyId> left = {stage.bodies[0], stage.bodies[1], stage.bodies[3], stage.bodies[4]};
  EXPECT_EQ(stage.world.bodies(), left);
  const BodyId again = stage.add(shape, Vec3(0, 5, 0));
  EXPECT_EQ(stage.world.bodies()[2], again);
}

TEST(SetVelocity, LeavesTheBodyWhereItIsAndWakesIt) {
  WorldSettings settings = heavy();
  settings.sleeping = true;
  Stage stage(settings);
  stage.plane(Vec3::UnitZ(), 0);
  const BodyId body = stage.add(stage.ball(0.5), Vec3(0, 0, 0.5));
  for (int frame = 0; frame < 120 && !stage.world.asleep(body).value(); ++frame) stage.world.step({});
  ASSERT_TRUE(stage.world.asleep(body).value());
  const BodyState before = stage.world.state(body).value();
  ASSERT_TRUE(stage.world.set_velocity(body, Vec3(1, 2, 3), Vec3(4, 5, 6)));
  EXPECT_FALSE(stage.world.asleep(body).value());
  const BodyState after = stage.world.state(body).value();
  EXPECT_EQ(after.position_m, before.position_m);
  EXPECT_EQ(after.velocity_mps, Vec3(1, 2, 3));
  EXPECT_EQ(after.angular_velocity_radps, Vec3(4, 5, 6));
  EXPECT_NE(refusal(stage.world.set_velocity(body, Vec3(std::nan(""), 0, 0), Vec3::Zero())).find("velocity_mps = [nan"),
            std::string::npos);
  const BodyId floor = stage.world.bodies()[0];
  EXPECT_EQ(refusal(stage.world.set_velocity(floor, Vec3::UnitX(), Vec3::Zero())),
            "velocity_mps: a static body must be at rest");
  EXPECT_FALSE(stage.world.set_velocity(BodyId{}, Vec3::Zero(), Vec3::Zero()));
}

TEST(RemoveShape, IsRefusedWhileBodiesUseIt) {
  Stage stage(heavy());
  const ShapeId shape = stage.ball(0.5);
  const BodyId a = stage.add(shape, Vec3(0, 0, 0));
  const BodyId b = stage.add(shape, Vec3(3, 0, 0));
  EXPECT_EQ(refusal(stage.world.remove_shape(shape)), "shape 0 is used by 2 bodies, must be used by none");
  ASSERT_TRUE(stage.world.remove_body(a));
  EXPECT_EQ(refusal(stage.world.remove_shape(shape)), "shape 0 is used by 1 body, must be used by none");
  stage.world.step({});
  ASSERT_TRUE(stage.world.remove_body(b));
  ASSERT_TRUE(stage.world.remove_shape(shape));
  const Status again = stage.world.remove_shape(shape);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, ErrorKind::StaleHandle);
  EXPECT_FALSE(stage.world.remove_shape(ShapeId{}));
  BodyDefinition body;
  body.shape = shape;
  body.material = stage.material;
  EXPECT_FALSE(stage.world.add_body(body));
  EXPECT_NE(stage.ball(0.25), shape);  // ids are never reused
  stage.bodies.clear();
  stage.add(ShapeId{1}, Vec3(0, 0, 0));
  StepInput input;
  input.reference = true;
  EXPECT_EQ(stage.world.step(input).status, StepStatus::Done);
}

TEST(RemoveMaterial, IsRefusedWhileBodiesUseIt) {
  Stage stage(heavy());
  const MaterialId other = stage.world.add_material({0.1, 0.2, 500}).value();
  BodyDefinition body;
  body.shape = stage.ball(0.5);
  body.material = other;
  const BodyId id = stage.world.add_body(body).value();
  EXPECT_EQ(refusal(stage.world.remove_material(other)), "material 1 is used by 1 body, must be used by none");
  ASSERT_TRUE(stage.world.remove_body(id));
  ASSERT_TRUE(stage.world.remove_material(other));
  EXPECT_FALSE(stage.world.remove_material(other));
  EXPECT_FALSE(stage.world.add_body(body));
  EXPECT_NE(stage.world.add_material({}).value(), other);
}

TEST(SetSettings, ChangesWhatTheNextStepGoesBy) {
  Stage stage(heavy());
  const BodyId body = stage.add(stage.ball(0.5), Vec3(0, 0, 100));
  WorldSettings settings = stage.world.settings();
  EXPECT_EQ(settings.gravity_mps2, Vec3(0, 0, -9.81));
  settings.gravity_mps2 = Vec3(3, 0, 0);
  settings.substeps = 5;
  settings.alpha = 0.02;
  settings.max_partners = 64;
  settings.contact = ContactModel::Paper;
  settings.seed = 9;
  settings.policy.size = 3;
  ASSERT_TRUE(stage.world.set_settings(settings));
  EXPECT_EQ(stage.world.settings().substeps, 5);
  EXPECT_EQ(stage.world.settings().policy.size, 3);
  StepInput input;
  input.dt_s = 0.5;
  stage.world.step(input);
  EXPECT_LT((stage.world.state(body).value().velocity_mps - Vec3(1.5, 0, 0)).norm(), 1e-12);
  scheduler::Policy policy;
  policy.kind = scheduler::PolicyKind::Fifo;
  ASSERT_TRUE(stage.world.set_policy(policy));
  EXPECT_EQ(stage.world.settings().policy.kind, scheduler::PolicyKind::Fifo);
  policy.size = -1;
  EXPECT_EQ(refusal(stage.world.set_policy(policy)), "policy.size = -1, must be in [0, 10]");
}

TEST(SetSettings, RefusesWhatIsFixedAndWhatIsOutOfRange) {
  Stage stage(heavy());
  const WorldSettings now = stage.world.settings();
  const auto with = [&](auto&& change) {
    WorldSettings settings = now;
    change(settings);
    return refusal(stage.world.set_settings(settings));
  };
  const std::string fixed = "it is fixed when a World is made";
  EXPECT_EQ(with([](WorldSettings& s) { s.threads = 2; }), "threads = 2, must stay 1: " + fixed);
  EXPECT_NE(with([](WorldSettings& s) { s.executor = ExecutorKind::Serial; }).find("executor = "), std::string::npos);
  EXPECT_NE(with([](WorldSettings& s) { s.spin = Nanoseconds(1); }).find("spin = 1, must stay"), std::string::npos);
  EXPECT_NE(with([](WorldSettings& s) { s.processors = {0}; }).find("processors"), std::string::npos);
  EXPECT_NE(with([](WorldSettings& s) { s.realtime_priority = 3; }).find("realtime_priority = 3"), std::string::npos);
  EXPECT_NE(with([](WorldSettings& s) { s.max_front_entries = 64; }).find("max_front_entries = 64"), std::string::npos);
  EXPECT_NE(with([](WorldSettings& s) { s.substeps = 17; }).find("substeps = 17, must be in [1, 16]"),
            std::string::npos);
  EXPECT_NE(with([](WorldSettings& s) { s.gravity_mps2.x() = std::nan(""); }).find("gravity_mps2"), std::string::npos);
  EXPECT_EQ(with([](WorldSettings&) {}), "");
  EXPECT_EQ(stage.world.settings().threads, now.threads);
}

TEST(SetSettings, KeepAPileWhereItRests) {
  Stage stage(heavy(), 0.0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId shape = stage.ball(0.5);
  for (int i = 0; i < 4; ++i) stage.add(shape, Vec3(0, 0, 0.5 + i));
  for (int frame = 0; frame < 60; ++frame) stage.world.step({});
  WorldSettings settings = stage.world.settings();
  for (const int substeps : {4, 1, 3}) {
    settings.substeps = substeps;
    ASSERT_TRUE(stage.world.set_settings(settings));
    for (int frame = 0; frame < 10; ++frame) {
      stage.world.step({});
      for (int i = 0; i < 4; ++i)
        ASSERT_NEAR(stage.world.state(stage.bodies[static_cast<std::size_t>(i)]).value().position_m.z(), 0.5 + i, 0.03);
    }
  }
}

TEST(SetSettings, WakeWhatSleepsWhenGravityTurnsOrSleepingEnds) {
  WorldSettings settings = heavy();
  settings.sleeping = true;
  Stage stage(settings, 0.0);
  stage.plane(Vec3::UnitZ(), 0);
  const BodyId body = stage.add(stage.ball(0.5), Vec3(0, 0, 0.5));
  const auto lie_still = [&] {
    for (int frame = 0; frame < 120 && !stage.world.asleep(body).value(); ++frame) stage.world.step({});
  };
  lie_still();
  ASSERT_TRUE(stage.world.asleep(body).value());
  settings = stage.world.settings();
  settings.gravity_mps2 = Vec3(0, 0, 9.81);
  ASSERT_TRUE(stage.world.set_settings(settings));
  EXPECT_FALSE(stage.world.asleep(body).value());
  stage.world.step({});
  EXPECT_GT(stage.world.state(body).value().velocity_mps.z(), 0.1);
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  ASSERT_TRUE(stage.world.set_settings(settings));
  lie_still();
  ASSERT_TRUE(stage.world.asleep(body).value());
  settings.sleeping = false;
  ASSERT_TRUE(stage.world.set_settings(settings));
  for (int frame = 0; frame < 60; ++frame) stage.world.step({});
  EXPECT_FALSE(stage.world.asleep(body).value());
  settings.sleeping = true;
  ASSERT_TRUE(stage.world.set_settings(settings));
  lie_still();
  EXPECT_TRUE(stage.world.asleep(body).value());
}

TEST(PairFilter, LetsPairsPassThroughEachOther) {
  Stage stage(heavy());
  stage.plane(Vec3::UnitZ(), 0);
  BodyDefinition body;
  body.shape = stage.ball(0.5);
  body.material = stage.material;
  std::vector<BodyId> balls;
  for (int i = 0; i < 3; ++i) {
    body.position_m = Vec3(2 * i, 0, 0.7);
    body.user_data = static_cast<std::uint64_t>(i);
    balls.push_back(stage.world.add_body(body).value());
  }
  struct Context {
    std::uint64_t ghost = 1;
  } context;
  PairFilter filter;
  filter.context = &context;
  filter.function = [](void* of, const FilteredPair& pair) {
    const std::uint64_t ghost = static_cast<const Context*>(of)->ghost;
    return pair.user_data_a != ghost && pair.user_data_b != ghost;
  };
  stage.world.set_pair_filter(filter);
  for (int frame = 0; frame < 60; ++frame) stage.world.step({});
  EXPECT_LT(stage.world.state(balls[1]).value().position_m.z(), -1);
  EXPECT_NEAR(stage.world.state(balls[2]).value().position_m.z(), 0.5, 0.05);
  // Pairs that the filter excluded collide again, and contacts that it now excludes end.
  context.ghost = 2;
  stage.world.set_pair_filter(filter);
  stage.world.step({});
  bool ended = false;
  for (const ContactEvent& event : stage.world.contact_events())
    ended |= event.kind == ContactEvent::Kind::End && event.b == balls[2];
  EXPECT_TRUE(ended);
  stage.world.set_pair_filter({});
  for (int frame = 0; frame < 5; ++frame) stage.world.step({});
  EXPECT_GT(stage.world.state(balls[2]).value().position_m.z(), 0.2);
}

TEST(PairFilter, UserDataThatItMayGoByWakesTheBody) {
  WorldSettings settings = heavy();
  settings.sleeping = true;
  Stage stage(settings);
  stage.plane(Vec3::UnitZ(), 0);
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(0, 0, 0.5));
  PairFilter filter;
  filter.function = [](void*, const FilteredPair& pair) { return pair.user_data_a != 7 && pair.user_data_b != 7; };
  stage.world.set_pair_filter(filter);
  for (int frame = 0; frame < 300 && !stage.world.asleep(ball).value(); ++frame) stage.world.step({});
  ASSERT_TRUE(stage.world.asleep(ball).value());
  ASSERT_TRUE(stage.world.set_user_data(ball, 0));
  stage.world.step({});
  EXPECT_TRUE(stage.world.asleep(ball).value()) << "it is what it was";
  ASSERT_TRUE(stage.world.set_user_data(ball, 7));
  for (int frame = 0; frame < 60; ++frame) stage.world.step({});
  EXPECT_LT(stage.at(ball).position_m.z(), -1);
}

TEST(PairFilter, ThatLetsAllMeetChangesNoBit) {
  Stage with(heavy());
  Stage without(heavy());
  for (Stage* stage : {&with, &without}) stage->jacks(60, 8);
  PairFilter all;
  all.function = [](void*, const FilteredPair& pair) { return pair.a.slot < pair.b.slot; };
  with.world.set_pair_filter(all);
  for (int frame = 0; frame < 30; ++frame) {
    with.world.step({});
    without.world.step({});
  }
  EXPECT_EQ(with.world.state_hash(), without.world.state_hash());
}

TEST(Result, OfAnErrorHasNoValueAndSaysSo) {
  const Result<int> bad = bad_input("x = 1, must be 2");
  EXPECT_THROW(static_cast<void>(bad.value()), std::bad_variant_access);
  EXPECT_EQ(bad.value_or(5), 5);
  EXPECT_EQ(Result<int>(3).value_or(5), 3);
  EXPECT_THROW(static_cast<void>(Result<int>(3).error()), std::bad_variant_access);
}

}  // namespace
}  // namespace poise
