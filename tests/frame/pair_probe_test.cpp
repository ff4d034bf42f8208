// SPDX-License-Identifier: MIT
#include "verify/pair_probe.h"

#include <gtest/gtest.h>

#include <limits>

#include "frame/scenes.h"
#include "geometry/primitives/random.h"

namespace poise::simulation {
namespace {

constexpr double kDt = 1.0 / 60;

ShapePtr jack() {
  std::vector<Sphere> spheres = {{Vec3::Zero(), 0.28}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      spheres.push_back({side * 0.35 * Vec3::Unit(axis), 0.22});
      spheres.push_back({side * 0.68 * Vec3::Unit(axis), 0.18});
    }
  }
  return make_spheres_shape(spheres).value();
}

PairState random_state(geometry::Random& random) {
  PairState state;
  state.a.orientation = random.rotation();
  state.b.orientation = random.rotation();
  state.b.position_m = 1.2 * random.direction();
  state.a.velocity_mps = 0.5 * state.b.position_m;
  state.b.velocity_mps = -state.b.position_m;
  state.a.angular_velocity_radps = random.direction();
  state.b.angular_velocity_radps = random.direction();
  return state;
}

TEST(PairProbe, AnswersTwoBallsAsInTheClosedForm) {
  const ShapePtr ball = make_sphere_shape(0.5).value();
  PairProbe probe = PairProbe::make({ball, ball, ContactModel::Wrench, 0.5, 1000}).value();
  PairState state;
  state.b.position_m = Vec3(1.01, 0, 0);
  state.a.velocity_mps = Vec3(2, 0.3, 0);
  const PairImpulse answer = probe.impulse(state, {}, kDt);
  ASSERT_TRUE(answer.met);
  EXPECT_NEAR(answer.gap_m, 0.01, 1e-12);
  EXPECT_TRUE(answer.dv_a_mps.isApprox(Vec3(-1.5, 0, 0), 1e-12));
  EXPECT_TRUE(answer.dv_b_mps.isApprox(Vec3(1.5, 0, 0), 1e-12));
  EXPECT_EQ(answer.dw_a_radps.norm(), 0);
  // At its own time of impact: when at most half a step's motion is left.
  EXPECT_TRUE(probe.acts(state, {}, 0.011));
  EXPECT_FALSE(probe.acts(state, {}, 0.009));
  state.b.position_m.x() = 5;
  EXPECT_FALSE(probe.impulse(state, {}, kDt).met);
}

TEST(PairProbe, SaysWhatAStepOfAWorldDoes) {
  const ShapePtr shape = jack();
  geometry::Random random(4);
  for (const ContactModel model : {ContactModel::Paper, ContactModel::Wrench, ContactModel::Fitted}) {
    PairProbe probe = PairProbe::make({shape, shape, model, 0.5, 1000}).value();
    WorldSettings settings;
    settings.contact = model;
    settings.executor = ExecutorKind::Serial;
    Stage stage(settings);
    const ShapeId id = stage.world.add_shape(shape);
    const BodyId a = stage.add(id, Vec3::Zero());
    const BodyId b = stage.add(id, Vec3(5, 0, 0));
    int acted = 0;
    int waited = 0;
    for (int round = 0; round < 200; ++round) {
      const PairState state = random_state(random);
      for (const Level level : {Level{0}, Level{1}, Level{2}}) {
        ASSERT_TRUE(stage.world.set_state(a, state.a));
        ASSERT_TRUE(stage.world.set_state(b, state.b));
        StepInput input = step_of(kDt);
        input.max_level = level;
        stage.world.step(input);
        const Vec3 change = stage.at(b).velocity_mps - state.b.velocity_mps;
        ASSERT_EQ(probe.acts(state, {level, false}, kDt), !change.isZero(0)) << "round " << round;
        ++(change.isZero(0) ? waited : acted);
        if (change.isZero(0)) continue;
        const PairImpulse answer = probe.impulse(state, {level, false}, kDt);
        ASSERT_EQ(answer.level, level);
        ASSERT_LT((answer.dv_b_mps - change).norm(), 1e-12);
      }
    }
    EXPECT_GT(acted, 50);
    EXPECT_GT(waited, 50);
  }
}

TEST(PairProbe, ForgetsWhatItWasAskedBefore) {
  const ShapePtr shape = jack();
  geometry::Random random(5);
  PairProbe used = PairProbe::make({shape, shape}).value();
  for (int round = 0; round < 50; ++round) {
    const PairState state = random_state(random);
    PairProbe fresh = PairProbe::make({shape, shape}).value();
    const PairImpulse once = used.impulse(state, {2, false}, kDt);
    const PairImpulse again = fresh.impulse(state, {2, false}, kDt);
    ASSERT_EQ(once.met, again.met);
    ASSERT_EQ(once.dv_a_mps, again.dv_a_mps);
    ASSERT_EQ(once.dw_b_radps, again.dw_b_radps);
  }
}

TEST(PairProbe, MeasuresMoreWorkAtDeeperLevels) {
  const ShapePtr shape = jack();
  geometry::Random random(6);
  std::vector<PairState> states;
  for (int i = 0; i < 100; ++i) states.push_back(random_state(random));
  const ProbeLevel levels[] = {{1, false}, {2, false}};
  const auto costs = PairProbe::costs({shape, shape}, states, levels, kDt, 3);
  ASSERT_TRUE(costs) << costs.error().message;
  ASSERT_EQ(costs.value().size(), 2U);
  for (const PairCost& cost : costs.value()) {
    EXPECT_GT(cost.refine_ns, 0);
    EXPECT_GT(cost.overlap_ns, 0);
    EXPECT_GT(cost.response_ns, 0);
  }
}

TEST(PairProbe, RefusesWhatNoWorldTakes) {
  const ShapePtr ball = make_sphere_shape(0.5).value();
  EXPECT_EQ(PairProbe::make({nullptr, ball}).error().message, "a, b: must be shapes");
  EXPECT_FALSE(PairProbe::make({ball, make_plane_shape(Vec3::UnitZ(), 0).value()}).ok());
  EXPECT_FALSE(PairProbe::make({ball, ball, ContactModel::Wrench, 1.5}).ok());
  EXPECT_FALSE(PairProbe::costs({ball, ball}, {}, {}, kDt, 1).ok());
  PairProbe probe = PairProbe::make({ball, ball}).value();
  PairState state;
  state.b.position_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(probe.impulse(state, {}, kDt).met);
}

}  // namespace
}  // namespace poise::simulation
