// SPDX-License-Identifier: MIT
#include "frame/budget/degrade.h"
#include "frame/refine/pair_cues.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "frame/budget/frame_time.h"
#include "frame/run_frame.h"
#include "frame/scenes.h"
#include "verify/world_access.h"

namespace poise {
namespace {

using simulation::WorldAccess;
using simulation::WorldState;

WorldSettings falling(int threads) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.threads = threads;
  return settings;
}

StepInput easy() {
  StepInput input = step_of(1.0 / 60);
  input.budget = Budget::within(std::chrono::minutes(10));
  return input;
}

// The counts that the stages of a World would get.
simulation::FrameCounts counts_of(const WorldState& world) {
  return {world.settings.contact, world.bodies.dynamic_count(), world.settings.substeps, world.outputs.table,
          world.outputs.levels};
}
simulation::RefineInput refine_input(const WorldState& world, const StepInput& input) {
  const WorldSettings& settings = world.settings;
  return {world.scene(),
          simulation::terms_of(settings, input),
          world.outputs.motion,
          world.outputs.table,
          settings.policy,
          input,
          world.frame,
          settings.seed,
          settings.substeps,
          settings.max_front_entries,
          {}};
}

TEST(Degrade, AnInfeasibleFrameSaysBeforehandThatItIsOneAndDoesWithFewerSubstepsAndOldPlaces) {
  Stage stage(falling(2), 0.2);
  stage.jacks(60, 4);
  for (int i = 0; i < 60; ++i) stage.world.step(easy());
  std::size_t reused = 0;
  for (int i = 0; i < 30; ++i) {
    const FrameReport report = stage.world.step(hopeless());
    EXPECT_TRUE(report.infeasible_forecast);
    EXPECT_EQ(report.degraded.substeps, 1);
    reused += report.degraded.pairs_reused;
  }
  EXPECT_GT(reused, 0U) << "no pair's places ever grew too old";
}

TEST(Degrade, RefinementHasAFifthOfAFrameWhoseReserveWouldTakeItAll) {
  Stage stage(falling(1), 0.2);
  stage.jacks(60, 4);
  for (int i = 0; i < 60; ++i) stage.world.step(easy());
  const WorldState& world = WorldAccess::of(stage.world);
  const SteadyClock::time_point now{std::chrono::hours(10)};  // invented, like all times that follow
  StepInput input = step_of(1.0 / 60);
  const auto plan = [&](Nanoseconds left, std::uint32_t refinable, FrameReport& report) {
    input.budget = Budget::until(now + left);
    simulation::Forecasts forecasts = world.forecasts;
    // A reserve of twice the forecast, for as many iterations whatever time there is.
    forecasts.margin =
        scheduler::TrackedQuantile(world.settings.alpha, scheduler::TrackedQuantile::kDefaultEta, std::log(2.0));
    forecasts.times.manifold_points = 1000;
    forecasts.times.iterations_a_substep = 1000;
    simulation::CompletedLevels levels;
    levels.progress = world.outputs.levels.progress;
    levels.known = world.outputs.levels.known;
    levels.known.refinable = refinable;
    return simulation::plan_frame(refine_input(world, input), now, forecasts, levels, report, *world.executor);
  };
  constexpr std::uint32_t kMany = 1'000'000;
  FrameReport far;
  plan(std::chrono::minutes(1), kMany, far);
  ASSERT_EQ(far.degraded.substeps, 0);
  ASSERT_GT(far.reserve_at_cut, far.tail_forecast);
  // The forecast fits, its reserve does not.
  const Nanoseconds left = (far.tail_forecast + far.reserve_at_cut) / 2;
  FrameReport tight;
  const simulation::FramePlan tight_plan = plan(left, kMany, tight);
  EXPECT_FALSE(tight.infeasible_forecast);
  EXPECT_EQ(tight.degraded.substeps, 0) << "it comes out of the margin: with fewer substeps a heap sinks";
  const Nanoseconds forecast = tight_plan.budget.tail_forecast(tight_plan.expected);
  const double margin_ns = (tight_plan.budget.margin - 1) * static_cast<double>(forecast.count());
  const Nanoseconds kept(static_cast<std::int64_t>(simulation::kMarginLeft * margin_ns));
  ASSERT_GT(kept, Nanoseconds(0));
  const scheduler::TimePoint fits = now + left - forecast - kept;
  EXPECT_GT(tight_plan.budget.cut(tight_plan.expected), now);
  EXPECT_GE(tight_plan.budget.cut(tight_plan.expected), std::min(now + left / 5, fits));
  FrameReport known;
  const simulation::FramePlan known_plan = plan(left, 0, known);
  EXPECT_EQ(known.degraded.substeps, 0);
  EXPECT_LT(known_plan.budget.cut(known_plan.expected), now) << "nothing is given where there is nothing to refine";
}

TEST(Degrade, AStepInSlicesEndsWithTheSliceInWhichRefinementHasItsShare) {
  Stage stage(falling(1), 0.2);
  stage.jacks(60, 4);
  for (int i = 0; i < 60; ++i) stage.world.step(easy());
  const WorldState& world = WorldAccess::of(stage.world);
  constexpr Nanoseconds kSlice = std::chrono::milliseconds(10), kBefore = std::chrono::milliseconds(3);
  const SteadyClock::time_point now{std::chrono::hours(10)};  // invented, like all times that follow
  StepInput input = step_of(1.0 / 60);
  constexpr std::uint32_t kRefinable = 1'000'000;
  // The plan where a pair takes so long by score, or in order.
  const auto plan = [&](double by_score_ns, double in_order_ns, Nanoseconds left) {
    input.budget = Budget::until(now + left);
    simulation::Forecasts forecasts = world.forecasts;
    forecasts.pair_cost.by_score_ns = by_score_ns;
    forecasts.pair_cost.in_order_ns = in_order_ns;
    forecasts.times.iterations_a_substep = 0;
    simulation::CompletedLevels levels;
    levels.progress = world.outputs.levels.progress;
    levels.known = world.outputs.levels.known;
    levels.known.refinable = kRefinable;
    simulation::RefineInput refine = refine_input(world, input);
    refine.step_begun = now - kBefore;
    refine.slice = kSlice;
    FrameReport report;
    simulation::FramePlan plan = simulation::plan_frame(refine, now, forecasts, levels, report, *world.executor);
    EXPECT_EQ(report.degraded.bodies_held, 0U);
    EXPECT_EQ(plan.deadline, levels.deadline);
    return plan;
  };
  const auto expect_time = [&](Nanoseconds time, const simulation::FramePlan& plan) {
    EXPECT_EQ((plan.deadline - now + kBefore) % kSlice, Nanoseconds(0)) << "whole slices";
    const Nanoseconds given = plan.budget.cut(plan.expected) - now - world.forecasts.times.planning;
    EXPECT_GE(given, time);
    EXPECT_LT(given, time + kSlice) << "no more slices than it takes";
  };
  constexpr Nanoseconds kFar = std::chrono::hours(1);
  expect_time(std::chrono::milliseconds(40), plan(100, 0, kFar));
  expect_time(std::chrono::milliseconds(80), plan(200, 0, kFar));
  // In order all pairs would take hardly longer, or much longer.
  expect_time(std::chrono::microseconds(55'555), plan(100, 50, kFar));
  expect_time(std::chrono::milliseconds(40), plan(100, 90, kFar));
  // No later than the step has time.
  constexpr Nanoseconds kShort = std::chrono::milliseconds(56);
  EXPECT_EQ(plan(100, 50, kShort).deadline, now + kShort);
}

TEST(Degrade, WhatPairsCostInTheOtherOrderIsLearnedWhereOneFollowsTheOther) {
  simulation::RefinementCost cost;
  for (int i = 0; i < 100; ++i) cost.learn(600, false);
  EXPECT_NEAR(cost.by_score_ns, 600, 1);
  EXPECT_NEAR(cost.in_order_ns, 600 * simulation::RefinementCost{}.order_share, 1) << "nothing else is known yet";
  for (int i = 0; i < 100; ++i) cost.learn(i % 2 == 0 ? 600 : 480, i % 2 != 0);
  EXPECT_NEAR(cost.order_share, 0.8, 0.01);
  // Either is followed by what is measured of the other.
  for (int i = 0; i < 100; ++i) cost.learn(960, true);
  EXPECT_NEAR(cost.in_order_ns, 960, 1);
  EXPECT_NEAR(cost.by_score_ns, 1200, 20);
}

TEST(Degrade, WhatAUnitCostsIsLearnedOfFewUnitsTooAndNotFromOneStall) {
  simulation::UnitCost cost;
  cost.learn(3e9, 2800);
  EXPECT_LE(cost.ns, 2 * simulation::UnitCost{}.ns) << "the program was stopped for three seconds";
  // Thought to be that dear, units were few, whatever they took.
  cost.ns = 1e4;
  for (int frame = 0; frame < 200; ++frame) cost.learn(20 * 50, 20);
  EXPECT_NEAR(cost.ns, 50, 5);
}

TEST(Degrade, WhatPairsCostIsNotToldByAFewThatAreLeftOver) {
  using simulation::RefinementCost;
  EXPECT_FALSE(RefinementCost::tells(15));
  EXPECT_TRUE(RefinementCost::tells(16)) << "of those that all went by score";
  EXPECT_FALSE(RefinementCost::tells(36, 3218)) << "they took eight times as long as others, by a record of jacks";
  EXPECT_TRUE(RefinementCost::tells(403, 3218));
}

TEST(Degrade, RestingContactIsStoppedWhereThereIsNoTimeForIt) {
  Stage stage(falling(2), 0.2);
  stage.jacks(30, 3);
  for (int i = 0; i < 90; ++i) {
    const FrameReport report = stage.world.step(easy());
    EXPECT_EQ(report.degraded.point_iterations, 0U);
  }
  const WorldState& world = WorldAccess::of(stage.world);
  for (int i = 0; i < 10; ++i) {
    const FrameReport stopped = stage.world.step(hopeless());
    EXPECT_GT(stopped.degraded.point_iterations, 0U);
    EXPECT_EQ(stopped.point_iterations, world.outputs.velocities.point_count) << "one sweep of one substep";
    EXPECT_LT(stopped.mandatory, stopped.times.total + Nanoseconds(1));
    const FrameReport whole = stage.world.step(easy());
    EXPECT_EQ(whole.degraded.point_iterations, 0U);
    EXPECT_GT(whole.point_iterations, 2 * world.outputs.velocities.point_count)
        << "it wanted no more than one sweep a substep";
  }
}

TEST(Degrade, MoreTimeIsMoreVisitsAndNoTimeIsOneSweep) {
  Stage stage(falling(1), 0.2);
  stage.jacks(60, 4);
  for (int i = 0; i < 90; ++i) stage.world.step(easy());
  const WorldState& world = WorldAccess::of(stage.world);
  FrameReport report;
  report.contact_pairs = world.outputs.manifolds.manifolds.size();
  const auto visits = [&](Nanoseconds time) {
    report.refine_started = SteadyClock::now();
    return simulation::iterations_in_time(world.forecasts, report.refine_started + time, counts_of(world),
                                          SteadyClock::now(), world.outputs.velocities.point_count, report);
  };
  EXPECT_EQ(visits(std::chrono::hours(-1)), 1U);
  EXPECT_EQ(visits(std::chrono::hours(1)), solver::kMaxPointIterations);
  // The cost of a point iteration is learned and positive, so there is a time at which the decision changes. The tested
  // times are far apart, since a real clock is read.
  const double us = world.forecasts.tail.coefficients_us()[scheduler::TailForecast::kPointIterations] * 1e-3 *
                    world.forecasts.margin.factor();
  ASSERT_GT(us, 0);
  const auto reserve = Nanoseconds(static_cast<std::int64_t>(
      world.forecasts.margin.factor() *
      static_cast<double>(
          world.forecasts.tail.forecast(simulation::tail_work(world.forecasts, counts_of(world), report.contact_pairs))
              .count())));
  const auto half = std::chrono::microseconds(
      static_cast<std::int64_t>(0.5 * us * solver::kMaxPointIterations * world.settings.substeps));
  const std::uint32_t some = visits(reserve + half);
  EXPECT_GT(some, solver::kMaxPointIterations / 10);
  report.host_reserved = std::chrono::hours(1);
  EXPECT_EQ(visits(reserve + half), 1U) << "the host's time is not resting contact's";
}

TEST(Degrade, ItRecoversAtOnce) {
  Stage stage(falling(2), 0.2);
  stage.jacks(60, 4);
  for (int i = 0; i < 60; ++i) stage.world.step(easy());
  for (int i = 0; i < 30; ++i) stage.world.step(hopeless());
  const FrameReport report = stage.world.step(easy());
  EXPECT_FALSE(report.degraded.any());
  EXPECT_FALSE(report.infeasible_forecast);
  EXPECT_EQ(report.pairs_left, 0U);
  EXPECT_EQ(report.lateness.count(), 0);
}

TEST(Degrade, CountedAndUnlimitedWorkIsNeverLeftOut) {
  Stage stage(falling(2), 0.2);
  stage.jacks(60, 4);
  for (int i = 0; i < 90; ++i) {
    StepInput input = step_of(1.0 / 60);
    if (i % 2 == 0) input.budget = Budget::work(0);
    const FrameReport report = stage.world.step(input);
    EXPECT_FALSE(report.degraded.any());
    EXPECT_FALSE(report.infeasible_forecast);
  }
}

TEST(Degrade, TheSameIsLeftOutToTheBitOnAnyNumberOfThreads) {
  std::uint64_t expected = 0;
  for (const int threads : {1, 2, 3}) {
    Stage stage(falling(threads), 0.2);
    stage.jacks(100, 5);
    for (int i = 0; i < 90; ++i) stage.world.step(i < 40 || i % 4 == 0 ? easy() : hopeless());
    if (threads == 1) expected = stage.world.state_hash();
    EXPECT_EQ(stage.world.state_hash(), expected);
  }
}

TEST(Degrade, APileAtRestStaysAtRestWhileSubstepsComeAndGo) {
  Stage stage(falling(1), 0);
  stage.tray(4);
  const ShapeId ball = stage.ball(0.5);
  for (int i = 0; i < 6; ++i) stage.add(ball, Vec3(0, 0, 0.5 + 1.0 * i));
  for (int i = 0; i < 120; ++i) stage.world.step(easy());
  double fastest = 0;
  for (int i = 0; i < 60; ++i) {
    const FrameReport report = stage.world.step(i % 3 == 0 ? hopeless() : easy());
    EXPECT_EQ(report.degraded.substeps, i % 3 == 0 ? 1 : 0);
    for (const BodyId body : stage.bodies) fastest = std::max(fastest, stage.at(body).velocity_mps.norm());
  }
  EXPECT_LT(fastest, 0.01);
  EXPECT_NEAR(stage.at(stage.bodies.back()).position_m.z(), 5.5, 0.02);
}

TEST(Degrade, TheLeastSeenAreReusedFirst) {
  WorldSettings settings = falling(1);
  Stage stage(settings, 0.2);
  stage.jacks(120, 5);
  WorldState& world = WorldAccess::of(stage.world);
  StepInput input = easy();
  const Vec3 forward = Vec3::UnitX();
  input.view = {true, Vec3(-6, 0, 1), forward, Vec3::UnitZ(), 0.87, 1.78, forward};
  // Until contact points have expired: no work for some frames.
  for (int i = 0; i < 70; ++i) stage.world.step(input);
  input.budget = Budget::work(0);
  std::size_t tried = 0;
  for (int i = 0; i < 40 && tried < 5; ++i) {
    simulation::Frame& frame = world.outputs;
    const simulation::StepTerms terms = simulation::terms_of(world.settings, input);
    simulation::predict({world.scene(), terms}, frame.motion, *world.executor);
    simulation::find_candidates({world.scene(), frame.motion, {world.settings.max_partners, world.settings.max_pairs}},
                                world.broad_phase, frame.candidates, *world.executor);
    simulation::find_active_pairs(
        {world.scene(), terms, frame.motion, frame.candidates, world.cache.pairs, world.pair_filter}, frame.table,
        world.pools, *world.executor);
    simulation::begin_levels(frame.table, frame.levels, *world.executor);
    const simulation::RefineInput refine = refine_input(world, input);
    std::vector<simulation::CacheUse> before;
    for (const auto& pair : frame.levels.progress) before.push_back(pair.cached);
    const auto choose = [&](Nanoseconds late) {
      return simulation::choose_reused(refine, late, 1, 1, frame.levels, *world.executor);
    };
    const std::size_t all = choose(std::chrono::hours(1));
    if (all >= 4) {
      ++tried;
      const std::vector<std::uint32_t> any = frame.levels.reused;
      EXPECT_EQ(choose(Nanoseconds(2)), 2U) << "no more than are needed";
      ASSERT_EQ(choose(Nanoseconds(static_cast<std::int64_t>(all / 2))), all / 2);
      simulation::degrade(refine, {0, all / 2}, frame.levels, *world.executor);
      const simulation::PairCueSource cues(refine);
      double most_reused = 0;
      double least_left = 1e300;
      std::size_t reused = 0;
      for (const std::uint32_t pair : any) {
        const bool is_reused = frame.levels.progress[pair].cached != before[pair];
        reused += is_reused ? 1U : 0U;
        (is_reused ? most_reused : least_left) =
            is_reused ? std::max(most_reused, cues.seen(pair)) : std::min(least_left, cues.seen(pair));
      }
      EXPECT_EQ(reused, all / 2);
      EXPECT_LE(most_reused, std::exp2(0.25) * least_left) << "in bands of a quarter of an octave";
    }
    stage.world.step(input);
  }
  EXPECT_GT(tried, 0U) << "no pair's places ever grew too old";
}

TEST(FrameTime, WhatOneWorldLearnedIsWhereAnotherBegins) {
  Stage stage(falling(1), 0.2);
  stage.jacks(60, 4);
  for (int i = 0; i < 80; ++i) stage.world.step(easy());
  const scheduler::TimePriors learned = stage.world.time_priors();
  EXPECT_EQ(learned.frames, 80U);
  EXPECT_GT(learned.spread, 0);
  Stage other(falling(1), 0.2);
  EXPECT_EQ(other.world.time_priors().frames, 0U);
  other.world.set_time_priors(learned);
  const scheduler::TimePriors taken = other.world.time_priors();
  EXPECT_EQ(taken.tail_us, learned.tail_us);
  EXPECT_EQ(taken.head_us, learned.head_us);
  // A learned margin above the initial one is replaced by the initial one.
  const double first = World::create(falling(1)).value().time_priors().log_quantile;
  EXPECT_DOUBLE_EQ(taken.log_quantile, std::min(learned.log_quantile, first));
  EXPECT_DOUBLE_EQ(taken.unit_cost_ns, learned.unit_cost_ns);
  scheduler::TimePriors senseless = learned;
  senseless.tail_us[1] = -3;
  senseless.unit_cost_ns = 0;
  other.world.set_time_priors(senseless);
  EXPECT_GE(other.world.time_priors().tail_us[1], 0);
  EXPECT_GT(other.world.time_priors().unit_cost_ns, 0);
  // Nor are years a cost that a run has learned.
  StepInput roomy = step_of(1.0 / 60);
  for (const double us : {1e12, 1e100, 1.7e308}) {
    senseless.tail_us.fill(us);
    senseless.head_us.fill(us);
    senseless.unit_cost_ns = us;
    other.world.set_time_priors(senseless);
    for (int frame = 0; frame < 5; ++frame) {
      roomy.budget = Budget::within(std::chrono::hours(1));
      const FrameReport report = other.world.step(roomy);
      EXPECT_FALSE(report.infeasible_forecast) << us;
      EXPECT_GE(report.mandatory_forecast.count(), 0) << us;
    }
    EXPECT_LE(other.world.time_priors().tail_us[1], 1e9);
    EXPECT_LE(other.world.time_priors().unit_cost_ns, 1e4);
  }
}

TEST(FrameTime, ASmallerAlphaKeepsMore) {
  WorldSettings rare = falling(1);
  rare.alpha = 0.001;
  const World careful = World::create(rare).value();
  const World plain = World::create(falling(1)).value();
  EXPECT_GT(careful.time_priors().log_quantile, plain.time_priors().log_quantile);
  rare.alpha = 0.6;
  EXPECT_FALSE(World::create(rare).ok());
  rare.alpha = 0;
  EXPECT_FALSE(World::create(rare).ok());
}

}  // namespace
}  // namespace poise
