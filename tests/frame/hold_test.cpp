// SPDX-License-Identifier: MIT
#include "frame/budget/hold.h"

#include <gtest/gtest.h>

#include "frame/waiting.h"
#include "verify/world_access.h"

namespace poise {
namespace {

using simulation::kMostFramesHeld;
using simulation::WorldAccess;
using simulation::WorldState;

// A heap of jacks that has come to rest in a tray.
struct Heap : Stage {
  explicit Heap(const WorldSettings& settings = gravity_on(1)) : Stage(settings, 0.2) {
    jacks(20, 4);
    for (int i = 0; i < 240; ++i) world.step(unlimited());
    EXPECT_GT(world.contacts().size(), 20U);
  }
};

TEST(Hold, AHeapAtRestWaitsAsItIsButForNoMoreFramesThanItMay) {
  Heap heap;
  for (int round = 0; round < 3; ++round) {
    std::vector<BodyState> before;
    for (const BodyId body : heap.bodies) before.push_back(heap.at(body));
    for (int i = 0; i < kMostFramesHeld; ++i) {
      const FrameReport report = heap.world.step(hopeless());
      ASSERT_EQ(report.degraded.bodies_held, heap.bodies.size()) << "frame " << i << " of round " << round;
      EXPECT_EQ(report.contact_pairs, 0U);
      EXPECT_TRUE(heap.world.contact_events().empty()) << "what touches goes on touching";
      for (std::size_t k = 0; k < heap.bodies.size(); ++k) ASSERT_TRUE(same(heap.at(heap.bodies[k]), before[k]));
    }
    const FrameReport stepped = heap.world.step(hopeless());
    EXPECT_EQ(stepped.degraded.bodies_held, 0U);
    EXPECT_GT(stepped.contact_pairs, 20U);
  }
}

TEST(Hold, AHeapThatWaitsNowAndThenMovesAsOneThatDoesNotOnlyLater) {
  Heap held;
  Heap free;
  for (int i = 0; i < 60; ++i) {
    for (int k = 0; k < kMostFramesHeld; ++k) ASSERT_GT(held.world.step(hopeless()).degraded.bodies_held, 0U);
    held.world.step(unlimited());
    free.world.step(unlimited());
    // To the bit: waiting is no event.
    for (std::size_t k = 0; k < held.bodies.size(); ++k)
      ASSERT_TRUE(same(held.at(held.bodies[k]), free.at(free.bodies[k]))) << "frame " << i;
  }
}

TEST(Hold, WhatMovesIsPushedOrDrivenDoesNotWaitAndWhatLiesApartFromItDoes) {
  WorldSettings settings = gravity_on(1);
  settings.islands_wait = IslandsWait::NearRest;
  Stage stage(settings, 0.0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  const BodyId rests = stage.add(ball, Vec3(-20, 0, 0.5));
  const BodyId beside = stage.add(ball, Vec3(-19, 0, 0.5));
  const BodyId rolls = stage.add(ball, Vec3(0, 0, 0.5), Vec3(3, 0, 0), Vec3(0, 6, 0));
  const BodyId pushed = stage.add(ball, Vec3(20, 0, 0.5));
  stage.world.step(unlimited());
  EXPECT_EQ(stage.world.step(hopeless()).degraded.bodies_held, 3U) << "all but the one that rolls";
  ASSERT_TRUE(stage.world.apply_force(pushed, Vec3(0, 0, 40000), stage.at(pushed).position_m).ok());
  const BodyState before = stage.at(rolls);
  EXPECT_EQ(stage.world.step(hopeless()).degraded.bodies_held, 2U) << "nor the one that is pushed";
  EXPECT_GT(stage.at(pushed).velocity_mps.z(), 0.05);
  EXPECT_GT(stage.at(rolls).position_m.x(), before.position_m.x());
  EXPECT_EQ(stage.at(rests).velocity_mps, stage.at(beside).velocity_mps);
  // A fast body that comes near an island belongs to it.
  stage.add(ball, Vec3(-21.5, 0, 0.5), Vec3(30, 0, 0));
  EXPECT_EQ(stage.world.step(hopeless()).degraded.bodies_held, 0U);
}

TEST(Hold, WhatFollowsAtTheSameSpeedDoesNotRunIntoWhatWaits) {
  Stage stage(gravity_on(1), 0.0);
  const ShapeId ball = stage.ball(0.1);
  const Vec3 velocity(40, 0, 0);
  const BodyId first = stage.add(ball, Vec3(0, 0.0999, 50), velocity);
  stage.add(ball, Vec3(0, -0.0999, 50), velocity);
  // Two thirds of a metre a step, and no pair by how they move against each other.
  const BodyId follows = stage.add(ball, Vec3(-0.5, 0.0999, 50), velocity);
  stage.world.step(unlimited());
  for (int i = 0; i < 10; ++i) {
    stage.world.step(hopeless());
    ASSERT_NEAR(stage.at(first).position_m.x() - stage.at(follows).position_m.x(), 0.5, 1e-3) << i;
  }
}

TEST(Hold, WhatMovesWaitsTooWhereItMayAfterWhatIsNearRest) {
  Stage stage(gravity_on(1), 0.0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  const BodyId rolls = stage.add(ball, Vec3(0, 0, 0.5), Vec3(3, 0, 0), Vec3(0, 6, 0));
  const BodyId rests = stage.add(ball, Vec3(-20, 0, 0.5));
  const BodyId falls = stage.add(ball, Vec3(20, 0, 30));
  const auto step = [&](const StepInput& input) { return stage.world.step(input).degraded.bodies_held; };
  step(unlimited());
  const BodyState rolling = stage.at(rolls);
  EXPECT_EQ(step(hopeless()), 2U) << "what meets nothing has nothing to wait for";
  EXPECT_TRUE(same(stage.at(rolls), rolling));
  EXPECT_LT(stage.at(falls).position_m.z(), 30);
  step(unlimited());
  // One contact less is all that is asked for: the one at rest gives it.
  simulation::WorldState& world = WorldAccess::of(stage.world);
  const StepInput input = hopeless();
  simulation::RefineInput refine{world.scene(),         simulation::terms_of(world.settings, input),
                                 world.outputs.motion,  world.outputs.table,
                                 world.settings.policy, input};
  refine.islands_wait = IslandsWait::Any;
  world.bodies.frames_held.assign(world.bodies.slot_count(), 0);
  simulation::begin_levels(world.outputs.table, world.outputs.levels, *world.executor);
  EXPECT_EQ(simulation::hold_islands(refine, 1, world.outputs.levels, *world.executor), 1U);
  EXPECT_TRUE(world.outputs.levels.held.holds(rests.slot));
  EXPECT_FALSE(world.outputs.levels.held.holds(rolls.slot));
}

TEST(Hold, AHeapInMotionThatWaitsMovesAsOneThatDoesNotOnlyLater) {
  Heap held;
  Heap free;
  for (Heap* heap : {&held, &free}) {
    for (std::size_t k = 0; k < heap->bodies.size(); ++k) {
      BodyState state = heap->at(heap->bodies[k]);
      state.velocity_mps = Vec3(k % 2 == 0 ? 1 : -1, k % 3 == 0 ? 1 : -1, 0.5);
      ASSERT_TRUE(heap->world.set_state(heap->bodies[k], state).ok());
    }
  }
  int together = 0;
  for (; together < 60; ++together) {
    // As long as all are one island that waits.
    if (held.world.step(hopeless()).degraded.bodies_held != held.bodies.size()) break;
    for (int k = 1; k < 3; ++k)
      ASSERT_EQ(held.world.step(hopeless()).degraded.bodies_held, held.bodies.size()) << together;
    held.world.step(unlimited());
    free.world.step(unlimited());
    for (std::size_t k = 0; k < held.bodies.size(); ++k)
      ASSERT_TRUE(same(held.at(held.bodies[k]), free.at(free.bodies[k]))) << "frame " << together;
  }
  EXPECT_GE(together, 5);
}

TEST(Hold, NoPairHasOneBodyThatWaitsAndOneThatMoves) {
  Heap heap;
  for (int i = 0; i < 12; ++i) heap.add(heap.jack(), Vec3(60 + 2.5 * i, 0, 6));
  const ShapeId ball = heap.ball(0.5);
  for (int i = 0; i < 12; ++i) heap.add(ball, Vec3(0.3 * i - 2, 0, 8 + 1.3 * i), Vec3(0, 0, -2));
  std::size_t held = 0;
  std::size_t moved = 0;
  for (int i = 0; i < 240; ++i) {
    const FrameReport report = heap.world.step(i % 3 == 0 ? hopeless() : unlimited());
    const WorldState& world = WorldAccess::of(heap.world);
    const simulation::CompletedLevels& levels = world.outputs.levels;
    held += report.degraded.bodies_held;
    for (std::size_t k = 0; k < world.outputs.table.size(); ++k) {
      const simulation::ActivePair& pair = world.outputs.table.pairs[k];
      for (const std::uint32_t slot : {pair.a, pair.b}) {
        if (world.bodies.dynamic[slot] == 0) continue;
        ASSERT_EQ(levels.held.holds(slot), levels.progress[k].held);
        moved += levels.progress[k].held ? 0U : 1U;
      }
    }
  }
  EXPECT_GT(held, 100U);
  EXPECT_GT(moved, 100U);
}

TEST(Hold, RefinementFindsOutWhatItCanOfPairsThatWait) {
  Heap heap;
  // A jump of all bodies together: what was known of them is not sure any more.
  for (const BodyId body : heap.bodies) {
    BodyState state = heap.at(body);
    state.position_m += Vec3(0, 0, 1e-4);
    ASSERT_TRUE(heap.world.set_state(body, state).ok());
  }
  StepInput now = hopeless();
  now.record = true;
  ASSERT_EQ(heap.world.step(now).degraded.bodies_held, heap.bodies.size());
  // What a frame with time for it would do: its decisions, with levels of some pairs.
  FrameDecisions decisions;
  heap.world.decisions(decisions);
  ASSERT_FALSE(decisions.held.empty());
  const WorldState& world = WorldAccess::of(heap.world);
  const std::uint64_t pairs = world.outputs.table.size();
  decisions.frame = world.frame;
  for (std::uint32_t k = 0; k < pairs; ++k) {
    const simulation::PairProgress& progress = world.outputs.levels.progress[k];
    for (Level level = 0; progress.refinable() && level < progress.level.deepest; ++level)
      decisions.steps.push_back({k, 0, RefinementStep::Kind::Completed});
  }
  ASSERT_GT(decisions.steps.size(), 20U);
  StepInput again = unlimited();
  again.replay = &decisions;
  const FrameReport report = heap.world.step(again);
  EXPECT_EQ(report.degraded.bodies_held, heap.bodies.size());
  EXPECT_GT(report.jobs_done, 20U);
  // The next frame has contacts at the deepest level without a level of its own.
  const FrameReport next = heap.world.step(unlimited());
  EXPECT_GT(next.contact_pairs, 20U);
  EXPECT_LT(next.jobs_done, report.jobs_done / 4);
}

TEST(Hold, AReplayHoldsTheSame) {
  Heap first;
  Heap second(gravity_on(2));
  ASSERT_EQ(first.world.state_hash(), second.world.state_hash());
  std::size_t held = 0;
  for (int i = 0; i < 40; ++i) {
    StepInput input = i % 10 < 8 ? hopeless() : unlimited();
    input.record = true;
    held += first.world.step(input).degraded.bodies_held;
    FrameDecisions decisions;
    first.world.decisions(decisions);
    StepInput replayed = unlimited();
    replayed.replay = &decisions;
    const FrameReport report = second.world.step(replayed);
    ASSERT_EQ(report.status, StepStatus::Done) << "frame " << i;
    ASSERT_EQ(first.world.state_hash(), second.world.state_hash()) << "frame " << i;
  }
  EXPECT_GT(held, 500U);
  FrameDecisions wrong;
  wrong.frame = WorldAccess::of(second.world).frame;
  wrong.active_pairs = static_cast<std::uint32_t>(WorldAccess::of(second.world).outputs.table.size());
  wrong.held = {3};
  StepInput replayed = unlimited();
  replayed.replay = &wrong;
  EXPECT_EQ(second.world.step(replayed).status, StepStatus::ReplayDiffers) << "3 is no root of an island";
}

TEST(Hold, NothingWaitsWhereItMayNotOrNeedNot) {
  WorldSettings never = gravity_on(1);
  never.islands_wait = IslandsWait::Never;
  Heap moving(never);
  EXPECT_EQ(moving.world.step(hopeless()).degraded.bodies_held, 0U);
  Heap heap;
  StepInput counted = unlimited();
  counted.budget = Budget::work(1);
  EXPECT_EQ(heap.world.step(counted).degraded.bodies_held, 0U);
  StepInput roomy = unlimited();
  roomy.budget = Budget::within(std::chrono::minutes(10));
  EXPECT_EQ(heap.world.step(roomy).degraded.bodies_held, 0U);
  StepInput swept = hopeless();
  swept.backtracking = true;
  EXPECT_EQ(heap.world.step(swept).degraded.bodies_held, 0U);
  WorldSettings adrift = gravity_on(1);
  adrift.gravity_mps2 = Vec3::Zero();
  Stage gas(adrift);
  gas.add(gas.ball(0.5), Vec3::Zero());
  gas.add(gas.ball(0.5), Vec3(0.99, 0, 0));
  EXPECT_EQ(gas.world.step(hopeless()).degraded.bodies_held, 0U);
}

}  // namespace
}  // namespace poise
