// SPDX-License-Identifier: MIT
#include "frame/budget/pause.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "frame/waiting.h"
#include "verify/world_access.h"

namespace poise {
namespace {

using simulation::kMostFramesHeld;
using simulation::kMostStepsUnseen;
using simulation::WorldAccess;

// Heaps far apart from each other that come down on a plane.
struct Heaps : Stage {
  explicit Heaps(int threads = 1, int count = 12) : Stage(gravity_on(threads), 0.2) {
    plane(Vec3::UnitZ(), 0);
    const ShapeId shapes[2] = {ball(0.5), jack()};
    for (int heap = 0; heap < count; ++heap) {
      for (int i = 0; i < 5; ++i) add(shapes[i % 2], Vec3(40.0 * heap + 0.2 * i, 0.1 * i, 0.8 + 1.2 * i));
    }
  }
};

// Decisions by which a step pauses the island of one body.
FrameDecisions that_pause(World& world, std::uint32_t root, std::uint32_t steps) {
  FrameDecisions decisions;
  decisions.frame = WorldAccess::of(world).frame;
  decisions.active_pairs = static_cast<std::uint32_t>(WorldAccess::of(world).outputs.table.size());
  decisions.paused = {{root, steps}};
  return decisions;
}

TEST(Pause, EveryBodyIsSteppedInEveryEighthFrameAndCostsNothingInBetween) {
  Heaps heaps;
  std::vector<int> waited(heaps.bodies.size(), 0);
  std::vector<BodyState> before(heaps.bodies.size());
  int most = 0;
  std::size_t paused = 0;
  for (int frame = 0; frame < 60; ++frame) {
    for (std::size_t k = 0; k < heaps.bodies.size(); ++k) before[k] = heaps.at(heaps.bodies[k]);
    const FrameReport report = heaps.world.step(hopeless());
    paused += report.degraded.bodies_paused;
    EXPECT_LE(report.degraded.bodies_paused, report.degraded.bodies_held);
    EXPECT_EQ(report.bodies, heaps.bodies.size()) << "who waits is still there";
    // Those that waited from the start were not looked at.
    const std::size_t looked_at = WorldAccess::of(heaps.world).outputs.motion.visited.size();
    if (frame > 16) {
      EXPECT_LT(looked_at, heaps.bodies.size());
    }
    for (std::size_t k = 0; k < heaps.bodies.size(); ++k) {
      waited[k] = same(heaps.at(heaps.bodies[k]), before[k]) ? waited[k] + 1 : 0;
      most = std::max(most, waited[k]);
    }
  }
  EXPECT_EQ(most, kMostFramesHeld);
  EXPECT_GT(paused, 60 * heaps.bodies.size() / 2);
}

TEST(Pause, TurnsAreSharedOutSoThatFramesAreAlike) {
  Heaps heaps(1, 64);
  for (int frame = 0; frame < 40; ++frame) heaps.world.step(hopeless());
  std::size_t least = heaps.bodies.size();
  std::size_t most = 0;
  for (int frame = 0; frame < 16; ++frame) {
    const std::size_t stepped = heaps.bodies.size() - heaps.world.step(hopeless()).degraded.bodies_held;
    least = std::min(least, stepped);
    most = std::max(most, stepped);
  }
  EXPECT_GE(least, heaps.bodies.size() / 16);
  EXPECT_LE(most, heaps.bodies.size() / 4);
}

TEST(Pause, AStepWithTimeForAllHasAll) {
  Heaps heaps;
  for (int frame = 0; frame < 10; ++frame) heaps.world.step(hopeless());
  std::vector<BodyState> before;
  for (const BodyId body : heaps.bodies) before.push_back(heaps.at(body));
  EXPECT_EQ(heaps.world.step(unlimited()).degraded.bodies_held, 0U);
  for (std::size_t k = 0; k < before.size(); ++k) EXPECT_FALSE(same(heaps.at(heaps.bodies[k]), before[k])) << k;
  for (int frame = 0; frame < 10; ++frame) heaps.world.step(hopeless());
  StepInput roomy = unlimited();
  roomy.budget = Budget::within(std::chrono::minutes(10));
  EXPECT_EQ(heaps.world.step(roomy).degraded.bodies_held, 0U);
}

TEST(Pause, WhatWaitsGoesOnAsIfItHadNotOnlyLater) {
  // One heap alone, so that it is clear when it is stepped.
  Heaps paused(1, 1);
  Heaps free(1, 1);
  for (int round = 0; round < 30; ++round) {
    StepInput now = unlimited();
    const FrameDecisions decisions = [&] {
      FrameDecisions made = that_pause(paused.world, paused.bodies[0].slot, 3);
      // What the step would do by itself: every level.
      StepInput recorded = unlimited();
      recorded.record = true;
      free.world.step(recorded);
      FrameDecisions all;
      free.world.decisions(all);
      all.frame = made.frame;
      all.paused = made.paused;
      return all;
    }();
    now.replay = &decisions;
    ASSERT_EQ(paused.world.step(now).status, StepStatus::Done) << round;
    for (std::size_t k = 0; k < paused.bodies.size(); ++k)
      ASSERT_TRUE(same(paused.at(paused.bodies[k]), free.at(free.bodies[k]))) << "round " << round << ", body " << k;
    FrameDecisions waits;
    for (int i = 0; i < 3; ++i) {
      waits.frame = WorldAccess::of(paused.world).frame;
      now.replay = &waits;
      const FrameReport report = paused.world.step(now);
      ASSERT_EQ(report.degraded.bodies_paused, paused.bodies.size()) << "round " << round << ", step " << i;
      ASSERT_EQ(report.coarse_pairs, 0U);
      ASSERT_TRUE(paused.world.contact_events().empty());
    }
  }
}

TEST(Pause, WhatIsHitTakesPartAtOnceAndNothingPassesThrough) {
  Stage stage(gravity_on(), 1.0);
  const ShapeId ball = stage.ball(0.5);
  stage.plane(Vec3::UnitZ(), 0);
  const BodyId waits = stage.add(ball, Vec3(0, 0, 0.5));
  const BodyId comes = stage.add(ball, Vec3(-6, 0, 0.5), Vec3(12, 0, 0));
  stage.world.step(unlimited());
  FrameDecisions decisions = that_pause(stage.world, waits.slot, kMostStepsUnseen);
  StepInput input = unlimited();
  input.replay = &decisions;
  stage.world.step(input);
  const double momentum = stage.at(comes).velocity_mps.x() + stage.at(waits).velocity_mps.x();
  const auto& paused = WorldAccess::of(stage.world).bodies.paused;
  EXPECT_EQ(paused[waits.slot], 1);
  int steps = 0;
  for (; steps < 25 && paused[waits.slot] != 0; ++steps) {
    FrameDecisions none;
    none.frame = WorldAccess::of(stage.world).frame;
    input.replay = &none;
    stage.world.step(input);
    EXPECT_GT((stage.at(comes).position_m - stage.at(waits).position_m).norm(), 0.98) << steps;
  }
  EXPECT_GT(steps, 10) << "it waits for as long as nothing is near";
  EXPECT_LT(steps, 25);
  for (int i = 0; i < 10; ++i) {
    stage.world.step(unlimited());
    EXPECT_GT((stage.at(comes).position_m - stage.at(waits).position_m).norm(), 0.98) << i;
  }
  EXPECT_GT(stage.at(waits).velocity_mps.x(), 5);
  EXPECT_NEAR(stage.at(comes).velocity_mps.x() + stage.at(waits).velocity_mps.x(), momentum, 1e-9);
}

TEST(Pause, TheCallersCallsWakeAndKeepWhatABodyHas) {
  Heaps heaps;
  for (int frame = 0; frame < 9; ++frame) heaps.world.step(hopeless());
  const auto& bodies = WorldAccess::of(heaps.world).bodies;
  const auto waiting = [&] {
    return *std::find_if(heaps.bodies.begin(), heaps.bodies.end(),
                         [&](const BodyId& body) { return bodies.paused[body.slot] != 0; });
  };
  const BodyId pushed = waiting();
  const BodyState before = heaps.at(pushed);
  EXPECT_FALSE(heaps.world.asleep(pushed).value());
  ASSERT_TRUE(heaps.world.apply_impulse(pushed, Vec3(bodies.mass_kg[pushed.slot], 0, 0), before.position_m).ok());
  EXPECT_NEAR(heaps.at(pushed).velocity_mps.x(), before.velocity_mps.x() + 1, 1e-12);
  EXPECT_EQ(heaps.at(pushed).velocity_mps.z(), before.velocity_mps.z());
  heaps.world.step(hopeless());
  EXPECT_GT(heaps.at(pushed).position_m.x(), before.position_m.x()) << "in the next step";
  const BodyId removed = waiting();
  ASSERT_TRUE(heaps.world.remove_body(removed).ok());
  for (int frame = 0; frame < 9; ++frame) EXPECT_EQ(heaps.world.step(hopeless()).status, StepStatus::Done);
}

TEST(Pause, WhatIsOutOfViewWaitsLongerAndTakesPartOnceItIsSeen) {
  Heaps heaps(1, 40);
  // Towards the last heap.
  const auto look = [&](StepInput input, const Vec3& forward) {
    input.view = {true, Vec3(800, 0, 2), forward, Vec3::UnitZ(), 0.6, 1.5, forward};
    return input;
  };
  std::vector<int> waited(heaps.bodies.size(), 0);
  int most_unseen = 0;
  int most_seen = 0;
  for (int frame = 0; frame < 120; ++frame) {
    std::vector<BodyState> before;
    for (const BodyId body : heaps.bodies) before.push_back(heaps.at(body));
    heaps.world.step(look(hopeless(), Vec3::UnitX()));
    for (std::size_t k = 0; k < before.size(); ++k) {
      waited[k] = same(heaps.at(heaps.bodies[k]), before[k]) ? waited[k] + 1 : 0;
      // The heap at 840 m fills more than a degree; what is beyond is seen smaller, what is before is not seen.
      const double x_m = before[k].position_m.x();
      if (x_m < 770) most_unseen = std::max(most_unseen, waited[k]);
      if (x_m > 830 && x_m < 860) most_seen = std::max(most_seen, waited[k]);
    }
  }
  EXPECT_GT(most_unseen, kMostFramesHeld);
  EXPECT_LE(most_unseen, kMostStepsUnseen);
  EXPECT_LE(most_seen, kMostFramesHeld);
  // The viewer turns round.
  heaps.world.step(look(hopeless(), -Vec3::UnitX()));
  std::size_t behind = 0;
  const auto& visited = WorldAccess::of(heaps.world).outputs.motion.visited;
  for (const BodyId body : heaps.bodies) {
    // The nearest heap. Those farther off are seen so small that they may go on waiting.
    const double x_m = heaps.at(body).position_m.x();
    if (x_m < 740 || x_m > 770) continue;
    ++behind;
    EXPECT_TRUE(std::binary_search(visited.begin(), visited.end(), body.slot)) << body.slot;
  }
  EXPECT_EQ(behind, 5U);
}

TEST(Pause, AReplayPausesTheSame) {
  Heaps first(1);
  Heaps second(2);
  std::size_t paused = 0;
  for (int i = 0; i < 80; ++i) {
    StepInput input = i % 20 < 16 ? hopeless() : unlimited();
    input.record = true;
    paused += first.world.step(input).degraded.bodies_paused;
    FrameDecisions decisions;
    first.world.decisions(decisions);
    StepInput replayed = unlimited();
    replayed.replay = &decisions;
    ASSERT_EQ(second.world.step(replayed).status, StepStatus::Done) << "frame " << i;
    ASSERT_EQ(first.world.state_hash(), second.world.state_hash()) << "frame " << i;
  }
  EXPECT_GT(paused, 1000U);
  // Of another run: no root, the same twice, and for too long.
  for (const std::vector<PausedIsland>& wrong : {std::vector<PausedIsland>{{second.bodies[1].slot, 3}},
                                                 {{second.bodies[0].slot, 3}, {second.bodies[0].slot, 3}},
                                                 {{second.bodies[0].slot, kMostStepsUnseen + 1U}}}) {
    second.world.step(unlimited());
    FrameDecisions decisions = that_pause(second.world, 0, 0);
    decisions.resumed = true;
    decisions.paused = wrong;
    StepInput replayed = unlimited();
    replayed.replay = &decisions;
    EXPECT_EQ(second.world.step(replayed).status, StepStatus::ReplayDiffers);
  }
  EXPECT_EQ(second.world.step(unlimited()).bodies, second.bodies.size());
}

TEST(Pause, TheReferenceCountsWhatWaitsAsAnError) {
  Heaps heaps(1, 10);
  // To the first contacts.
  for (int i = 0; i < 30; ++i) heaps.world.step(unlimited());
  StepInput input = unlimited();
  input.reference = true;
  const FrameReport free = heaps.world.step(input);
  ASSERT_GT(free.reference->bodies_touched, heaps.bodies.size() / 2);
  EXPECT_LT(free.reference->e_rel.value(), 0.2);
  std::size_t of_paused = 0;
  for (int i = 0; i < 20; ++i) {
    StepInput late = hopeless();
    late.reference = true;
    const FrameReport report = heaps.world.step(late);
    if (report.degraded.bodies_held < heaps.bodies.size() || report.degraded.bodies_paused == 0) continue;
    // All wait: the whole change of velocity is missing.
    of_paused += report.reference->bodies_touched;
    EXPECT_NEAR(report.reference->e_rel.value(), 1.0, 1e-12);
    EXPECT_EQ(report.reference->missed_contacts, report.reference->reference_contacts);
  }
  EXPECT_GT(of_paused, 0U);
}

TEST(Pause, SleepersSleepOnAndWhatWaitsMayFallAsleepLater) {
  WorldSettings settings = gravity_on();
  settings.sleeping = true;
  Stage stage(settings, 0.0);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  std::vector<BodyId> rest;
  for (int i = 0; i < 6; ++i) rest.push_back(stage.add(ball, Vec3(10.0 * i, 0, 0.5)));
  for (int i = 0; i < 120; ++i) stage.world.step(unlimited());
  for (const BodyId body : rest) ASSERT_TRUE(stage.world.asleep(body).value());
  const BodyId late = stage.add(ball, Vec3(0, 30, 0.5));
  std::size_t asleep = 0;
  for (int i = 0; i < 400; ++i) asleep = stage.world.step(hopeless()).asleep;
  EXPECT_EQ(asleep, 7U);
  EXPECT_TRUE(stage.world.asleep(late).value());
}

TEST(Pause, NothingIsPausedWhereNothingMayWait) {
  for (const IslandsWait wait : {IslandsWait::Never, IslandsWait::NearRest}) {
    WorldSettings settings = gravity_on();
    settings.islands_wait = wait;
    Stage stage(settings, 0.0);
    stage.plane(Vec3::UnitZ(), 0);
    const ShapeId ball = stage.ball(0.5);
    for (int i = 0; i < 8; ++i) stage.add(ball, Vec3(20.0 * i, 0, 60), Vec3(1, 0, -5));
    for (int i = 0; i < 20; ++i) EXPECT_EQ(stage.world.step(hopeless()).degraded.bodies_paused, 0U) << i;
  }
}

}  // namespace
}  // namespace poise
