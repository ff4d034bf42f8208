// SPDX-License-Identifier: MIT
#include "frame/sliced_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "frame/waiting.h"
#include "verify/world_access.h"

namespace poise {
namespace {

using simulation::WorldAccess;

// A frame that is over before it begins, and holds an item a worker.
StepInput sliced() {
  StepInput input = hopeless();
  input.may_slice = true;
  return input;
}
StepInput roomy() {
  StepInput input = unlimited();
  input.budget = Budget::within(std::chrono::hours(1));
  input.may_slice = true;
  return input;
}

// However slow the machine is, each step moves all.
WorldSettings nobody_waits() {
  WorldSettings settings = gravity_on();
  settings.islands_wait = IslandsWait::Never;
  return settings;
}

// Jacks that fall into a tray, so many that a stage has several items.
struct SlicedFall : Stage {
  explicit SlicedFall(int threads, const WorldSettings& settings = nobody_waits())
      : Stage(with(settings, threads), 0.2) {
    jacks(300, 9);
  }
  static WorldSettings with(WorldSettings settings, int threads) {
    settings.threads = threads;
    return settings;
  }
  [[nodiscard]] std::vector<BodyState> states() const {
    std::vector<BodyState> all;
    for (const BodyId body : bodies) all.push_back(at(body));
    return all;
  }
  // Runs frames until one leaves its step unfinished.
  void begin() {
    for (int i = 0; i < 100 && !world.step_unfinished(); ++i) world.step(sliced());
    ASSERT_TRUE(world.step_unfinished());
  }
};

bool all_same(const std::vector<BodyState>& x, const std::vector<BodyState>& y) {
  return std::equal(x.begin(), x.end(), y.begin(), y.end(), same);
}

TEST(SlicedStep, UntilItEndsNothingMovesAndThenAllOfIt) {
  SlicedFall fall(2);
  std::size_t unfinished = 0;
  std::size_t finished = 0;
  std::vector<Contact> listed;
  for (std::uint64_t frame = 0; finished < 90; ++frame) {
    const std::vector<BodyState> before = fall.states();
    const FrameReport report = fall.world.step(sliced());
    EXPECT_EQ(report.frame, frame);
    EXPECT_EQ(report.status, StepStatus::Done);
    EXPECT_EQ(report.unfinished, fall.world.step_unfinished());
    EXPECT_EQ(report.bodies, fall.bodies.size());
    if (!report.unfinished) {
      ++finished;
      EXPECT_FALSE(all_same(fall.states(), before));
      listed.assign(fall.world.contacts().begin(), fall.world.contacts().end());
      continue;
    }
    ++unfinished;
    ASSERT_TRUE(all_same(fall.states(), before)) << "frame " << frame;
    EXPECT_EQ(report.degraded.bodies_held, fall.bodies.size());
    EXPECT_TRUE(fall.world.contact_events().empty());
    EXPECT_EQ(fall.world.contacts().size(), listed.size()) << "those that were asked for before it began";
  }
  EXPECT_GT(unfinished, finished);
  EXPECT_GT(listed.size(), 20U);
}

TEST(SlicedStep, WithAHostThatWantsMoreThanThereIsEveryFrameIsLate) {
  SlicedFall fall(2);
  for (int frame = 0; frame < 60; ++frame) {
    StepInput input = sliced();
    input.budget = Budget::within(std::chrono::milliseconds(1));
    input.host_work.expected = std::chrono::seconds(1);
    const FrameReport report = fall.world.step(input);
    EXPECT_GE(report.host_reserved, std::chrono::milliseconds(999)) << frame;
    EXPECT_GT(report.lateness, std::chrono::milliseconds(900)) << frame;
  }
}

TEST(SlicedStep, WhoAsksForContactsTooLateGetsNone) {
  SlicedFall fall(1);
  for (int i = 0; i < 80; ++i) fall.world.step(unlimited());
  fall.begin();
  EXPECT_TRUE(fall.world.contacts().empty());
  while (fall.world.step_unfinished()) fall.world.step(sliced());
  EXPECT_FALSE(fall.world.contacts().empty());
}

TEST(SlicedStep, AReplayDoesTheSameOnAnyNumberOfThreads) {
  WorldSettings settings = gravity_on();
  settings.sleeping = true;
  settings.policy.learning = 1;
  settings.policy.onset = 1;
  SlicedFall first(2, settings);
  SlicedFall second(4, settings);
  std::size_t unfinished = 0;
  for (int i = 0; i < 1500; ++i) {
    StepInput input = i % 100 < 80 ? sliced() : roomy();
    // What is looked at while it goes on counts for the next one.
    const double turn = 0.01 * i;
    const Vec3 forward(std::cos(turn), std::sin(turn), 0);
    input.view = {true, Vec3(0, 0, 3), forward, Vec3::UnitZ(), 0.9, 1.5, forward};
    input.record = true;
    unfinished += first.world.step(input).unfinished ? 1U : 0U;
    FrameDecisions decisions;
    first.world.decisions(decisions);
    EXPECT_EQ(decisions.unfinished, first.world.step_unfinished());
    StepInput replayed = unlimited();
    replayed.view = input.view;
    replayed.replay = &decisions;
    const FrameReport again = second.world.step(replayed);
    ASSERT_EQ(again.status, StepStatus::Done) << "frame " << i;
    ASSERT_EQ(second.world.step_unfinished(), first.world.step_unfinished()) << "frame " << i;
    ASSERT_EQ(first.world.state_hash(), second.world.state_hash()) << "frame " << i;
  }
  EXPECT_GT(unfinished, 500U);
}

TEST(SlicedStep, WhatTheCallerChangesEndsItFirst) {
  const std::vector<std::function<void(SlicedFall&)>> changes = {
      [](SlicedFall& f) { f.add(f.ball(0.2), Vec3(0, 0, 90)); },
      [](SlicedFall& f) { EXPECT_TRUE(f.world.remove_body(f.bodies.back()).ok()); },
      [](SlicedFall& f) { EXPECT_TRUE(f.world.set_state(f.bodies[3], f.at(f.bodies[3])).ok()); },
      [](SlicedFall& f) { EXPECT_TRUE(f.world.set_velocity(f.bodies[3], Vec3::UnitX(), Vec3::Zero()).ok()); },
      [](SlicedFall& f) { EXPECT_TRUE(f.world.apply_force(f.bodies[3], Vec3::UnitX(), Vec3::Zero()).ok()); },
      [](SlicedFall& f) { EXPECT_TRUE(f.world.apply_torque(f.bodies[3], Vec3::UnitX()).ok()); },
      [](SlicedFall& f) { EXPECT_TRUE(f.world.apply_impulse(f.bodies[3], Vec3::UnitX(), Vec3::Zero()).ok()); },
      [](SlicedFall& f) { EXPECT_TRUE(f.world.set_groups(f.bodies[3], 2, 1).ok()); },
      [](SlicedFall& f) { EXPECT_TRUE(f.world.set_importance(f.bodies[3], 2).ok()); },
      [](SlicedFall& f) { EXPECT_TRUE(f.world.set_user_data(f.bodies[3], 2).ok()); },
      [](SlicedFall& f) { EXPECT_TRUE(f.world.set_settings(f.world.settings()).ok()); },
      [](SlicedFall& f) { f.world.set_pair_filter({}); },
      [](SlicedFall& f) {
        EXPECT_TRUE(f.world.add_material({0.1, 0.1, 500}).ok());
      },
      [](SlicedFall& f) {
        EXPECT_TRUE(f.world.remove_material(f.world.add_material({0.1, 0.1, 500}).value()).ok());
      }};
  for (std::size_t k = 0; k < changes.size(); ++k) {
    SlicedFall fall(2);
    for (int i = 0; i < 5; ++i) fall.world.step(unlimited());
    const BodyState before = fall.at(fall.bodies[0]);
    fall.begin();
    changes[k](fall);
    EXPECT_FALSE(fall.world.step_unfinished()) << "change " << k;
    EXPECT_FALSE(same(fall.at(fall.bodies[0]), before)) << "change " << k;
    // It goes on as ever.
    for (int i = 0; i < 20; ++i) EXPECT_EQ(fall.world.step(sliced()).status, StepStatus::Done);
  }
}

TEST(SlicedStep, EnergiesAreThoseOfWhatIsSeenWhoeverChangesIt) {
  SlicedFall fall(2);
  StepInput input = sliced();
  input.measure_energy = true;
  std::size_t unfinished = 0;
  for (int i = 0; i < 200; ++i) {
    if (i % 7 == 0) {
      const Status set = fall.world.set_velocity(fall.bodies.front(), Vec3(0.1 * i, 0, 0), Vec3::Zero());
      ASSERT_TRUE(set.ok()) << set.error().message;
    }
    const FrameReport report = fall.world.step(input);
    if (report.unfinished) ++unfinished;
    const Conserved seen = fall.world.conserved();
    EXPECT_EQ(report.kinetic_j, seen.kinetic_j) << "frame " << i;
    EXPECT_EQ(report.potential_j, seen.potential_j);
    EXPECT_EQ(report.momentum_ns, seen.momentum_ns);
  }
  EXPECT_GT(unfinished, 20U);
}

TEST(SlicedStep, ABodyWhoseVelocityIsSetHasMovedWithTheOthers) {
  SlicedFall fall(2);
  for (int i = 0; i < 5; ++i) fall.world.step(unlimited());
  const BodyState before = fall.at(fall.bodies[3]);
  fall.begin();
  EXPECT_TRUE(fall.world.set_velocity(fall.bodies[3], Vec3::UnitX(), Vec3::Zero()).ok());
  EXPECT_NE(fall.at(fall.bodies[3]).position_m, before.position_m);
  EXPECT_EQ(fall.at(fall.bodies[3]).velocity_mps, Vec3::UnitX());
}

TEST(SlicedStep, WhoFellAsleepIsSeenWhenItEnds) {
  WorldSettings settings = nobody_waits();
  settings.sleeping = true;
  Stage stage(settings, 0.2);
  stage.plane(Vec3::UnitZ(), 0);
  const ShapeId ball = stage.ball(0.5);
  for (int i = 0; i < 400; ++i) stage.add(ball, Vec3(2.0 * (i % 20), 2.0 * (i / 20), 0.5));
  const auto asleep = [&] {
    std::vector<bool> all;
    for (const BodyId body : stage.bodies) all.push_back(stage.world.asleep(body).value());
    return all;
  };
  std::size_t unfinished = 0;
  std::size_t fell = 0;
  for (int frame = 0; frame < 20000 && fell < 400; ++frame) {
    const std::vector<bool> before = asleep();
    const FrameReport report = stage.world.step(sliced());
    if (!report.unfinished) {
      fell += report.fell_asleep;
      continue;
    }
    ++unfinished;
    ASSERT_EQ(asleep(), before) << "frame " << frame;
  }
  EXPECT_GT(unfinished, 100U);
  EXPECT_GE(fell, 400U);
}

TEST(SlicedStep, QueriesFindWhatACallThatEndsItHasMoved) {
  SlicedFall fall(1);
  const BodyId probe = fall.add(fall.ball(0.5), Vec3(0, 0, 400), Vec3(0, 0, -600));
  fall.begin();
  const auto found_at = [&](const Vec3& point) {
    std::vector<BodyId> found;
    EXPECT_TRUE(fall.world.overlap_sphere(point, 0.01, found).ok());
    return std::ranges::count(found, probe) == 1;
  };
  const Vec3 before = fall.at(probe).position_m;
  ASSERT_TRUE(found_at(before));
  ASSERT_TRUE(fall.world.apply_force(fall.bodies.front(), Vec3(0, 0, 1), Vec3::Zero()).ok());
  ASSERT_LT(fall.at(probe).position_m.z(), before.z() - 9);
  EXPECT_FALSE(found_at(before));
  EXPECT_TRUE(found_at(fall.at(probe).position_m));
}

TEST(SlicedStep, AFrameWithoutADeadlineEndsIt) {
  SlicedFall fall(2);
  fall.begin();
  const std::vector<BodyState> before = fall.states();
  EXPECT_FALSE(fall.world.step(unlimited()).unfinished);
  EXPECT_FALSE(all_same(fall.states(), before));
  EXPECT_FALSE(fall.world.step(unlimited()).unfinished);
}

TEST(SlicedStep, WhereThereIsTimeAgainStepsAreDoneAtOnce) {
  SlicedFall fall(2);
  fall.begin();
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(fall.world.step(roomy()).unfinished);
  EXPECT_FALSE(WorldAccess::of(fall.world).sliced->last) << "not even in one slice";
}

TEST(SlicedStep, WhereLessThanAThirdOfRefinementFitsBodiesWaitAndThenAStepIsDoneInSlices) {
  SlicedFall fall(2, gravity_on());
  for (int i = 0; i < 80; ++i) fall.world.step(unlimited());
  simulation::WorldState& world = WorldAccess::of(fall.world);
  // All pairs of the last frame as dear as so many hours together; the deadline is an hour away.
  const auto step_with = [&](double hours) {
    constexpr double kHourNs = 3.6e12;
    world.forecasts.pair_cost.by_score_ns = hours * kHourNs / world.outputs.table.known_of_chunk.back().refinable;
    const FrameReport report = fall.world.step(roomy());
    EXPECT_FALSE(report.unfinished);
    return report.degraded.bodies_held;
  };
  for (int i = 0; i < 5; ++i) EXPECT_EQ(step_with(1e-3), 0U);
  ASSERT_GT(world.outputs.table.known_of_chunk.back().refinable, 200U);
  EXPECT_EQ(step_with(2), 0U) << "half of it fits";
  EXPECT_FALSE(world.sliced->last);
  EXPECT_GT(step_with(4), fall.bodies.size() / 4) << "a quarter";
  EXPECT_FALSE(world.sliced->last) << "in this frame all is done at once";
  step_with(1e-3);
  EXPECT_TRUE(world.sliced->last);
  // It took no hours.
  EXPECT_EQ(step_with(1e-3), 0U);
  EXPECT_FALSE(world.sliced->last);
  // Of what a policy leaves out it is not known how much that is.
  WorldSettings settings = world.settings;
  settings.policy.seen_threshold_rad = 1e-9;
  ASSERT_TRUE(fall.world.set_settings(settings));
  EXPECT_EQ(step_with(4), 0U);
}

TEST(SlicedStep, IsForWhoAsksForItAndHasADeadline) {
  const std::vector<std::function<void(StepInput&)>> inputs = {
      [](StepInput& input) { input.may_slice = false; }, [](StepInput& input) { input.backtracking = true; },
      [](StepInput& input) { input.reference = true; }, [](StepInput& input) { input.budget = Budget::work(100); },
      [](StepInput& input) { input.budget = Budget::unlimited(); }};
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    SlicedFall fall(2);
    for (int i = 0; i < 10; ++i) {
      StepInput input = sliced();
      inputs[k](input);
      EXPECT_FALSE(fall.world.step(input).unfinished) << "input " << k;
    }
    EXPECT_EQ(WorldAccess::of(fall.world).sliced, nullptr) << "costs nothing";
  }
}

// Heaps of four jacks, far from each other.
struct ManyHeaps : Stage {
  explicit ManyHeaps(int threads) : Stage(one_substep(threads), 0.2) {
    plane(Vec3::UnitZ(), 0);
    const ShapeId shape = jack();
    for (int i = 0; i < 200; ++i) {
      // They slide, so that a step changes what rests too.
      for (int k = 0; k < 4; ++k)
        add(shape, Vec3(20.0 * (i % 20), 20.0 * (i / 20), 0.8 + 1.3 * k), 0.1 * Vec3::UnitX());
    }
  }
  static WorldSettings one_substep(int threads) {
    WorldSettings settings = gravity_on(threads);
    settings.substeps = 1;
    return settings;
  }
};

// They wake by the number of the step, in whichever frame it ended.
TEST(SlicedStep, IslandsThatTakeTurnsAreReplayed) {
  ManyHeaps first(2);
  ManyHeaps second(3);
  std::size_t paused = 0;
  std::size_t unfinished = 0;
  for (int finished = 0; finished < 60;) {
    StepInput input = sliced();
    input.record = true;
    const FrameReport report = first.world.step(input);
    unfinished += report.unfinished ? 1U : 0U;
    finished += report.unfinished ? 0 : 1;
    FrameDecisions decisions;
    first.world.decisions(decisions);
    paused += decisions.paused.size();
    StepInput replayed = unlimited();
    replayed.replay = &decisions;
    ASSERT_EQ(second.world.step(replayed).status, StepStatus::Done) << "frame " << report.frame;
    ASSERT_EQ(first.world.state_hash(), second.world.state_hash()) << "frame " << report.frame;
  }
  EXPECT_GT(paused, 0U);
  EXPECT_GT(unfinished, 100U);
}

// A step takes many frames here. Were turns counted in frames, all of them would be over when the next step begins.
TEST(SlicedStep, IslandsTakeTurnsFromStepToStep) {
  ManyHeaps stage(2);
  const auto states = [&] {
    std::vector<BodyState> all;
    for (const BodyId body : stage.bodies) all.push_back(stage.at(body));
    return all;
  };
  std::vector<BodyState> before = states();
  std::vector<int> waited(before.size(), 0);
  std::size_t moved = 0;
  std::size_t unfinished = 0;
  constexpr int kFirst = 20;
  constexpr int kSteps = 60;
  for (int finished = 0; finished < kSteps;) {
    if (stage.world.step(sliced()).unfinished) {
      ++unfinished;
      continue;
    }
    ++finished;
    const std::vector<BodyState> now = states();
    for (std::size_t k = 0; k < now.size(); ++k) {
      waited[k] = same(now[k], before[k]) ? waited[k] + 1 : 0;
      ASSERT_LT(waited[k], 8) << "body " << k << " after step " << finished;
      if (finished > kFirst && waited[k] == 0) ++moved;
    }
    before = now;
  }
  // As many as bodies wait for at most; from then on a frame does more than an item.
  EXPECT_GE(unfinished, 8U * kSteps);
  EXPECT_LT(moved, (kSteps - kFirst) * before.size() / 2) << "most wait in most steps";
}

TEST(SlicedStep, IslandsThatCouldTakeTurnsAreLookedForAgainAfterAWhile) {
  const auto finish = [](World& world) {
    // However fast the machine is, once something is known all of it does not fit.
    double& ns_of_load = WorldAccess::of(world).forecasts.times.ns_of_load;
    if (ns_of_load > 0) ns_of_load = 1e6;
    while (world.step(sliced()).unfinished) {
    }
  };
  ManyHeaps stage(2);
  simulation::WorldState& many = WorldAccess::of(stage.world);
  for (int i = 0; i < 10; ++i) {
    many.forecasts.times.no_turns = 1;
    finish(stage.world);
    EXPECT_EQ(many.forecasts.times.no_turns, i == 0 ? 1 : 0) << "nothing is known of the first step";
    EXPECT_EQ(many.bodies.paused_count(), 0U);
  }
  finish(stage.world);
  EXPECT_GT(many.bodies.paused_count(), 0U);
  EXPECT_EQ(many.forecasts.times.no_turns, 0);
  // One heap is looked at once in four steps.
  SlicedFall fall(2, gravity_on());
  for (int i = 0; i < 80; ++i) fall.world.step(unlimited());
  simulation::WorldState& one = WorldAccess::of(fall.world);
  int looks = 0;
  for (int i = 0; i < 12; ++i) {
    const int before = one.forecasts.times.no_turns;
    finish(fall.world);
    if (before == 0 && one.forecasts.times.no_turns > 0) ++looks;
  }
  EXPECT_EQ(one.bodies.paused_count(), 0U);
  EXPECT_GE(looks, 2);
  EXPECT_LE(looks, 3);
}

TEST(SlicedStep, AWorldMayGoOrMoveWhileItIsUnfinished) {
  std::optional<SlicedFall> fall;
  fall.emplace(2);
  fall->begin();
  World moved = std::move(fall->world);
  EXPECT_TRUE(moved.step_unfinished());
  while (moved.step_unfinished()) EXPECT_EQ(moved.step(sliced()).status, StepStatus::Done);
  for (int i = 0; i < 100 && !moved.step_unfinished(); ++i) moved.step(sliced());
  EXPECT_TRUE(moved.step_unfinished());
}

TEST(SlicedStep, QueriesFindBodiesWhereTheyAre) {
  SlicedFall fall(2);
  fall.begin();
  const Vec3 at = fall.at(fall.bodies[0]).position_m;
  const Conserved before = fall.world.conserved();
  const std::uint64_t hash = fall.world.state_hash();
  EXPECT_EQ(fall.world.state_hash(), hash);
  const Result<ClosestPoint> closest = fall.world.closest_point(fall.bodies[0], at + Vec3(0, 0, 3));
  ASSERT_TRUE(closest.ok());
  EXPECT_LT((closest.value().point_m - at).norm(), 1.0);
  EXPECT_EQ(fall.world.conserved().kinetic_j, before.kinetic_j);
}

}  // namespace
}  // namespace poise
