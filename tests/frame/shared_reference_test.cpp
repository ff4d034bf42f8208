// SPDX-License-Identifier: MIT
#include "verify/shared_reference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "frame/scenes.h"
#include "verify/refinement_oracle.h"
#include "verify/world_access.h"

namespace poise {
namespace {

using simulation::SavedState;
using simulation::SharedReference;
using simulation::WorldAccess;

WorldSettings serial_world() {
  WorldSettings settings = one_thread_with_gravity();
  settings.executor = ExecutorKind::Serial;
  return settings;
}

StepInput limited_to(std::uint64_t units) {
  StepInput input = step_of(1.0 / 60);
  input.budget = Budget::work(units);
  return input;
}

TEST(SavedState, LeadsToTheBitsThatTheWorldWouldHaveHad) {
  Stage stage(serial_world(), 0.2);
  stage.jacks(60, 5);
  for (int i = 0; i < 60; ++i) stage.world.step(limited_to(80));
  SavedState saved;
  simulation::save(WorldAccess::of(stage.world), saved);
  const std::uint64_t hash = stage.world.state_hash();
  for (int i = 0; i < 30; ++i) stage.world.step(limited_to(80));
  const std::uint64_t later = stage.world.state_hash();
  // Whatever happens in between leaves nothing behind.
  for (int i = 0; i < 15; ++i) stage.world.step(step_of(1.0 / 60));
  ASSERT_TRUE(stage.world.remove_body(stage.bodies[3]).ok());
  stage.add(stage.ball(0.4), Vec3(0, 0, 30));
  stage.world.step(step_of(1.0 / 60));
  simulation::restore(saved, WorldAccess::of(stage.world));
  EXPECT_EQ(stage.world.state_hash(), hash);
  EXPECT_TRUE(stage.world.contains(stage.bodies[3]));
  for (int i = 0; i < 30; ++i) stage.world.step(limited_to(80));
  EXPECT_EQ(stage.world.state_hash(), later);
}

TEST(SavedState, OfBodiesAsleepLeadsToTheSameBitsToo) {
  WorldSettings settings = serial_world();
  settings.sleeping = true;
  Stage stage(settings, 0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  for (int i = 0; i < 4; ++i) stage.add(ball, Vec3(3.0 * i, 0, 0.5 + (i == 3 ? 4 : 0)));
  for (int i = 0; i < 40; ++i) stage.world.step(step_of(1.0 / 60));
  SavedState saved;
  simulation::save(WorldAccess::of(stage.world), saved);
  for (int i = 0; i < 40; ++i) stage.world.step(step_of(1.0 / 60));
  const std::uint64_t later = stage.world.state_hash();
  simulation::restore(saved, WorldAccess::of(stage.world));
  for (int i = 0; i < 40; ++i) stage.world.step(step_of(1.0 / 60));
  EXPECT_EQ(stage.world.state_hash(), later);
}

// A heap in which pairs are worth refining.
struct FallenJacks : Stage {
  FallenJacks() : Stage(serial_world(), 0.2) {
    jacks(60, 5);
    for (int i = 0; i < 70; ++i) world.step(step_of(1.0 / 60));
  }
};

TEST(SharedReference, TellsTheBodiesOfAnErrorAndTakesStepsOfOtherViewsWithoutOne) {
  FallenJacks stage;
  SharedReference shared;
  shared.save(stage.world);
  shared.begin(stage.world);
  StepInput input = limited_to(60);
  std::vector<simulation::ComparedBody> touched;
  stage.world.step(input);
  const ReferenceFigures plain = shared.compare(stage.world, input, &touched);
  ASSERT_EQ(touched.size(), plain.bodies_touched);
  ASSERT_GT(touched.size(), 10U);
  double eps2 = 0;
  for (std::size_t i = 0; i < touched.size(); ++i) {
    eps2 += simulation::squared_error_m2ps2(touched[i]);
    EXPECT_TRUE(i == 0 || touched[i].slot > touched[i - 1].slot);
  }
  EXPECT_NEAR(std::sqrt(eps2 / static_cast<double>(touched.size())), *plain.e_mps, 1e-12);
  // Another view refines other pairs; the reference of the state holds for it too.
  input.view.present = true;
  input.view.position_m = Vec3(-12, 0, 4);
  shared.rewind(stage.world);
  stage.world.step(input);
  StepInput without_view = input;
  without_view.view = {};
  const ReferenceFigures viewed = shared.compare(stage.world, without_view);
  FallenJacks alone;
  input.reference = true;
  EXPECT_EQ(viewed.e_mps, alone.world.step(input).reference.value().e_mps);
  EXPECT_EQ(viewed.e_seen_mps, viewed.e_mps) << "not weighed for a viewer";
}

TEST(SharedReference, SaysOfEachWayWhatAReferenceOfItsOwnSays) {
  const std::array<std::uint64_t, 3> budgets{0, 60, 1000000};
  FallenJacks stage;
  SharedReference shared;
  shared.save(stage.world);
  shared.begin(stage.world);
  for (const std::uint64_t units : budgets) {
    StepInput input = limited_to(units);
    input.view.present = true;
    input.view.position_m = Vec3(-12, 0, 4);
    shared.rewind(stage.world);
    stage.world.step(input);
    const ReferenceFigures together = shared.compare(stage.world, input);
    FallenJacks alone;
    input.reference = true;
    const ReferenceFigures apart = alone.world.step(input).reference.value();
    EXPECT_EQ(together.e_mps, apart.e_mps) << units;
    EXPECT_EQ(together.e_rel, apart.e_rel) << units;
    EXPECT_EQ(together.e_seen_mps, apart.e_seen_mps) << units;
    EXPECT_EQ(together.gap_mean_px, apart.gap_mean_px) << units;
    EXPECT_EQ(together.false_contacts, apart.false_contacts) << units;
    EXPECT_EQ(together.iterations, apart.iterations) << units;
  }
}

TEST(RefinementOracle, FirstRefinesThePairWhoseErrorIsSeenMost) {
  Stage stage(serial_world(), 0);
  const ShapeId jack = stage.jack();
  // Arms that pass each other, which level 0 takes for a collision; the second pair is ten times as fast.
  for (const double speed_mps : {1.0, 10.0}) {
    const double y_m = 10 * speed_mps;
    stage.add(jack, Vec3(0, y_m, 0), Vec3(speed_mps, 0, 0));
    stage.add(jack, Vec3(0.9, y_m + 0.75, 0.6), Vec3(-speed_mps, 0, 0));
  }
  SharedReference shared;
  shared.begin(stage.world);
  const StepInput nothing = limited_to(0);
  stage.world.step(nothing);
  ASSERT_GT(shared.compare(stage.world, nothing).e_mps.value(), 0.1);
  simulation::OracleOrder order;
  const std::vector<std::uint64_t> units(2, 10);
  const simulation::WorldState& state = WorldAccess::of(stage.world);
  simulation::extend(state, shared.reference(), {}, units, 1, order);
  ASSERT_EQ(order.ids.size(), 1U);
  EXPECT_EQ(order.units, 10U);
  EXPECT_EQ(order.ids[0], std::uint64_t{stage.bodies[2].slot} << 32U | stage.bodies[3].slot);
  simulation::extend(state, shared.reference(), {}, units, 100, order);
  EXPECT_EQ(order.ids.size(), 2U) << "no pair is listed twice";
  const simulation::OracleScores scores(order.ids);
  const scheduler::HostPolicy policy = scores.policy();
  const auto score = [&](std::uint64_t id) { return policy.function({}, {id, 0, {}, 1}, {}, policy.context); };
  EXPECT_GT(score(order.ids[0]), score(order.ids[1]));
  EXPECT_GT(score(order.ids[1]), 0);
  EXPECT_EQ(score(12345), 0) << "what is not listed comes last";
}

}  // namespace
}  // namespace poise
