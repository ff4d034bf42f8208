// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <numeric>
#include <vector>

#include "frame/refine/rank.h"
#include "frame/scenes.h"
#include "geometry/meshes.h"
#include "verify/world_access.h"

namespace poise {
namespace {

WorldSettings falling() {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.threads = 2;
  return settings;
}

TEST(Budget, RefinementIsChargedNoMoreThanTheWorkBudget) {
  Stage stage(falling(), 0.2);
  stage.jacks(150, 5.2);
  bool spent = false;
  for (int i = 0; i < 100; ++i) {
    StepInput input = step_of(1.0 / 60);
    input.budget = Budget::work(200);
    const FrameReport report = stage.world.step(input);
    EXPECT_LE(report.work_refine, 200U);
    spent = spent || (report.work_refine > 150 && report.pairs_left > 0);
  }
  EXPECT_TRUE(spent) << "the scene never asked for more than the budget";
}

TEST(Budget, NoWorkLeavesEveryPairAtItsMandatoryLevel) {
  Stage stage(falling(), 0.2);
  stage.jacks(60, 4);
  for (int i = 0; i < 80; ++i) {
    StepInput input = step_of(1.0 / 60);
    input.budget = Budget::work(0);
    const FrameReport report = stage.world.step(input);
    EXPECT_EQ(report.jobs_done, 0U);
    EXPECT_EQ(report.level_histogram[0], report.contact_pairs);
    EXPECT_EQ(report.pairs_left, report.coarse_pairs);
  }
}

TEST(Budget, ADeadlineThatHasPassedStillGivesASoundFrameAndIsCalledInfeasible) {
  Stage stage(falling(), 0.2);
  stage.jacks(60, 4);
  for (int i = 0; i < 80; ++i) {
    StepInput input = step_of(1.0 / 60);
    input.budget = Budget::until(SteadyClock::now() - std::chrono::milliseconds(5));
    const FrameReport report = stage.world.step(input);
    EXPECT_EQ(report.jobs_done, 0U);
    EXPECT_GT(report.lateness.count(), 0);
    EXPECT_EQ(report.cause, MissCause::Infeasible);
  }
  for (const BodyId body : stage.bodies) EXPECT_GT(stage.at(body).position_m.z(), 0);
}

TEST(Budget, AFarDeadlineRefinesEverythingToTheBitLikeNoDeadline) {
  std::uint64_t hashes[2];
  for (int run = 0; run < 2; ++run) {
    Stage stage(falling(), 0.2);
    stage.jacks(100, 5);
    for (int i = 0; i < 90; ++i) {
      StepInput input = step_of(1.0 / 60);
      if (run == 1) input.budget = Budget::within(std::chrono::minutes(10));
      const FrameReport report = stage.world.step(input);
      EXPECT_EQ(report.pairs_left, 0U);
      EXPECT_EQ(report.lateness.count(), 0);
    }
    hashes[run] = stage.world.state_hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Budget, HostWorkIsReservedWhetherGivenOrLearned) {
  Stage stage(falling(), 0.2);
  stage.jacks(60, 4);
  for (int i = 0; i < 50; ++i) stage.world.step(step_of(1.0 / 60));
  StepInput input = step_of(1.0 / 60);
  input.budget = Budget::within(std::chrono::minutes(1));
  input.host_work.expected = std::chrono::minutes(2);
  FrameReport report = stage.world.step(input);
  EXPECT_EQ(report.jobs_done, 0U) << "all of the time belongs to the host";
  EXPECT_EQ(report.host_reserved, std::chrono::minutes(2));

  input.budget = Budget::within(std::chrono::minutes(1));
  input.host_work = {};
  input.host_work.learn = true;
  report = stage.world.step(input);
  EXPECT_EQ(report.host_reserved.count(), 0) << "nothing was reported yet";
  EXPECT_GT(report.jobs_done, 0U);
  stage.world.report_host_work(std::chrono::minutes(2));
  input.budget = Budget::within(std::chrono::minutes(1));
  report = stage.world.step(input);
  EXPECT_GE(report.host_reserved, std::chrono::minutes(2));
  EXPECT_EQ(report.jobs_done, 0U);
}

// Ranking pairs takes time too. If there is too little time, some of the pairs are ranked, and others in the next
// frame.
TEST(Ranking, TheBestSeenAreRankedInEveryFrameAndTheOthersInTurn) {
  simulation::PairTable table;
  table.known_of_chunk.resize(41);
  for (std::size_t chunk = 0; chunk < 40; ++chunk) {
    table.known_of_chunk[chunk].refinable = 100;
    table.known_of_chunk[chunk].seen = chunk == 7 || chunk == 21 ? 200 : 10;
  }
  std::vector<std::uint32_t> chosen;
  std::vector<int> turns(40, 0);
  for (std::uint64_t frame = 0; frame < 14; ++frame) {
    simulation::choose_chunks(table, frame, 800, chosen);
    EXPECT_LE(chosen.size(), 8U + 1U);
    for (const std::uint32_t chunk : chosen) ++turns[chunk];
  }
  for (std::size_t chunk = 0; chunk < turns.size(); ++chunk)
    EXPECT_EQ(turns[chunk], chunk == 7 || chunk == 21 ? 14 : 2) << chunk;
  // The best seen are too many for half of what is allowed: all in turn.
  for (std::size_t chunk = 0; chunk < 40; ++chunk) table.known_of_chunk[chunk].seen = 200;
  simulation::choose_chunks(table, 3, 800, chosen);
  EXPECT_EQ(chosen, (std::vector<std::uint32_t>{2, 7, 12, 17, 22, 27, 32, 37}));
  simulation::choose_chunks(table, 3, 4000, chosen);
  EXPECT_EQ(chosen.size(), 40U);
}

TEST(Budget, TimeIsKeptForTheContactPointsOfPairsThatComeToNoEnd) {
  WorldSettings settings = falling();
  settings.policy.kind = scheduler::PolicyKind::Random;  // compares pairs at each level
  Stage stage(settings, 0.2);
  stage.jacks(300, 6);
  simulation::WorldState& world = simulation::WorldAccess::of(stage.world);
  StepInput input = step_of(1.0 / 60);
  std::size_t stopped = 0;
  for (int i = 0; i < 100; ++i) {
    world.forecasts.pair_cost.in_order_ns = 1e18;  // so long that the order matters
    // In every other frame one entry takes longer than the hour that there is.
    const bool dear = i % 2 == 1;
    world.forecasts.entry_cost_ns = dear ? 1e15 : 1;
    input.budget = Budget::within(std::chrono::hours(1));
    const FrameReport report = stage.world.step(input);
    EXPECT_TRUE(dear || report.pairs_left == 0) << "there was an hour for them";
    const simulation::CompletedLevels& levels = world.outputs.levels;
    std::int64_t due = 0;
    for (const simulation::PairProgress& pair : levels.progress) {
      if (!pair.points_due) continue;
      due += simulation::entries_of_points(pair.level);
      EXPECT_FALSE(levels.found.of(pair).points_due) << "they are made in the end";
    }
    EXPECT_EQ(world.open.due.get(), due);
    EXPECT_TRUE(dear || due == 0);
    if (due > 0 && report.pairs_left > 0) ++stopped;
  }
  EXPECT_GT(stopped, 5U) << "nothing was refined any more once there were points to make";
}

TEST(Budget, NoMorePairsAreRankedThanThereIsTimeForAndTheOthersHaveTheirTurnTheSame) {
  Stage stage(falling(), 0.2);
  stage.jacks(500, 6);
  simulation::WorldState& world = simulation::WorldAccess::of(stage.world);
  const simulation::PairTable& table = world.outputs.table;
  StepInput input = step_of(1.0 / 60);
  // Nothing is cached, so that every chunk has pairs to rank.
  const auto step_with = [&](double rank_cost_ns) {
    for (const BodyId body : stage.bodies) EXPECT_TRUE(stage.world.set_state(body, stage.at(body)));
    world.forecasts.rank_cost_ns = rank_cost_ns;
    world.forecasts.pair_cost.in_order_ns = 1e18;  // so long that the order matters
    input.budget = Budget::within(std::chrono::hours(1));
    return stage.world.step(input);
  };
  FrameReport report;
  for (int i = 0; i < 100; ++i) report = step_with(30);
  const auto refinable = [&] { return table.known_of_chunk.back().refinable; };
  ASSERT_GE(table.chunks(), 15U);
  EXPECT_EQ(report.pairs_ranked, refinable());
  for (int i = 0; i < 8; ++i) {
    // All pairs would take 2.5 times as long as ranking may.
    const double hour_ns = 3.6e12;
    report = step_with(2.5 * simulation::kRankingShare * hour_ns / refinable());
    EXPECT_GT(report.pairs_ranked, 0U);
    EXPECT_LT(report.pairs_ranked, 0.6 * refinable());
    EXPECT_EQ(report.pairs_left, 0U) << "there was an hour for them";
  }
  EXPECT_EQ(step_with(1e15).jobs_done, 0U) << "there is no time to rank any";
  EXPECT_EQ(step_with(30).pairs_left, 0U);
}

// A job may be abandoned with what it reads; a host is asked while the step waits for the answer.
TEST(Budget, AHostIsAskedOfPairsThatThereIsTimeToRankAndOfNoOthers) {
  Stage stage(falling(), 0.2);
  stage.jacks(500, 6);
  simulation::WorldState& world = simulation::WorldAccess::of(stage.world);
  std::atomic<std::size_t> asked{0};
  WorldSettings settings = world.settings;
  settings.policy.cue = {[](const scheduler::PairView&, void* context) noexcept {
                           ++*static_cast<std::atomic<std::size_t>*>(context);
                           return 1.0;
                         },
                         &asked};
  ASSERT_TRUE(stage.world.set_settings(settings));
  StepInput input = step_of(1.0 / 60);
  const auto step_with = [&](double rank_cost_ns) {
    for (const BodyId body : stage.bodies) EXPECT_TRUE(stage.world.set_state(body, stage.at(body)));
    world.forecasts.rank_cost_ns = rank_cost_ns;
    input.budget = Budget::within(std::chrono::hours(1));
    asked = 0;
    return stage.world.step(input);
  };
  for (int i = 0; i < 100; ++i) step_with(30);
  const double refinable = world.outputs.table.known_of_chunk.back().refinable;
  const FrameReport report = step_with(2.5 * simulation::kRankingShare * 3.6e12 / refinable);
  EXPECT_GT(report.pairs_ranked, 0U);
  EXPECT_EQ(asked.load(), report.pairs_ranked);
  EXPECT_GT(report.pairs_left, 0U);
}

// Of pairs that there is no time to rank, those come last that were ranked low last, whatever they would score now.
TEST(Budget, APairIsServedWhereItWasRankedLast) {
  Stage stage(falling(), 0.2);
  stage.jacks(500, 6);
  simulation::WorldState& world = simulation::WorldAccess::of(stage.world);
  const simulation::PairTable& table = world.outputs.table;
  StepInput input = step_of(1.0 / 60);
  input.record = true;
  const auto step_with = [&](double rank_cost_ns) {
    for (const BodyId body : stage.bodies) EXPECT_TRUE(stage.world.set_state(body, stage.at(body)));
    for (simulation::CachedPair& pair : world.cache.pairs) pair.band = pair.low % 2 == 0 ? 1 : 200;
    world.forecasts.rank_cost_ns = rank_cost_ns;
    world.forecasts.pair_cost.in_order_ns = 1e18;
    input.budget = Budget::within(std::chrono::hours(1));
    return stage.world.step(input);
  };
  for (int i = 0; i < 100; ++i) step_with(30);
  const auto refinable = static_cast<double>(table.known_of_chunk.back().refinable);
  const FrameReport report = step_with(4 * simulation::kRankingShare * 3.6e12 / refinable);
  ASSERT_LT(report.pairs_ranked, 0.6 * refinable);
  FrameDecisions decisions;
  stage.world.decisions(decisions);
  std::vector<bool> met(table.size(), false);
  std::vector<bool> low;
  for (const RefinementStep& step : decisions.steps) {
    if (!met[step.pair]) low.push_back(table.pairs[step.pair].low() % 2 == 0);
    met[step.pair] = true;
  }
  ASSERT_GT(low.size(), 100U);
  const auto half = static_cast<std::ptrdiff_t>(low.size() / 2);
  const auto first = std::count(low.begin(), low.begin() + half, true);
  const auto second = std::count(low.end() - half, low.end(), true);
  EXPECT_GT(second, 2 * first);
}

TEST(Budget, PairsAreRankedOnlyWhereHalfOfTheTimeMayNotBeEnough) {
  Stage stage(falling(), 0.2);
  stage.jacks(200, 5);
  simulation::WorldState& world = simulation::WorldAccess::of(stage.world);
  StepInput input = step_of(1.0 / 60);
  const auto step_with = [&](double pair_cost_ns) {
    for (const BodyId body : stage.bodies) EXPECT_TRUE(stage.world.set_state(body, stage.at(body)));
    world.forecasts.pair_cost.in_order_ns = pair_cost_ns;
    world.forecasts.rank_cost_ns = 1e15;  // there is no time to rank any
    input.budget = Budget::within(std::chrono::hours(1));
    return stage.world.step(input);
  };
  for (int i = 0; i < 100; ++i) step_with(1);
  const auto refinable = static_cast<double>(world.outputs.table.known_of_chunk.back().refinable);
  ASSERT_GE(refinable, 120);
  const double half_an_hour_ns = 1.8e12;
  FrameReport report = step_with(0.9 * half_an_hour_ns / refinable);
  EXPECT_EQ(report.pairs_left, 0U) << report.fronts_full << " full, " << report.jobs_discarded << " discarded, "
                                   << report.jobs_abandoned << " abandoned, " << world.open.cut.get() << " cut, "
                                   << world.open.ended.get() << " ended of " << refinable;
  EXPECT_GT(report.jobs_done, 120U);
  EXPECT_LT(world.forecasts.pair_cost.in_order_ns, 0.9 * half_an_hour_ns / refinable) << "it learns";
  EXPECT_EQ(step_with(1.1 * half_an_hour_ns / refinable).jobs_done, 0U);
  EXPECT_EQ(step_with(0).jobs_done, 0U) << "nothing is known";
  // What is to be left out, and what a host says of pairs, is asked for.
  WorldSettings settings = world.settings;
  settings.policy.seen_threshold_rad = 1e-9;
  ASSERT_TRUE(stage.world.set_settings(settings));
  EXPECT_EQ(step_with(1).jobs_done, 0U);
}

TEST(Budget, MaxLevelBoundsEveryPair) {
  Stage stage(falling(), 0.2);
  stage.jacks(60, 4);
  StepInput input = step_of(1.0 / 60);
  input.max_level = 1;
  for (int i = 0; i < 80; ++i) {
    const FrameReport report = stage.world.step(input);
    EXPECT_EQ(std::accumulate(report.level_histogram.begin() + 2, report.level_histogram.end(), 0U), 0U);
  }
}

TEST(Budget, WhatIsSeenIsRefinedFirst) {
  // Two piles far apart, a viewer at one of them, and work for a part: the visible pile gets it.
  WorldSettings settings = falling();
  settings.policy.waiting = 0;
  Stage stage(settings, 0.2);
  const ShapeId jack = stage.jack();
  stage.plane(Vec3::UnitZ(), 0);
  for (int i = 0; i < 40; ++i) {
    for (const double side : {-50.0, 50.0}) {
      stage.add(jack, Vec3(side + 0.9 * (i % 4), 0.9 * ((i / 4) % 4), 0.9 + 0.9 * (i / 16)), Vec3::Zero(), Vec3::Zero(),
                Quat(1, 0.1 * i, 0.3, 0.2));
    }
  }
  StepInput input = step_of(1.0 / 60);
  input.budget = Budget::work(60);
  const Vec3 forward(1, 0, 0);
  input.view = {true, Vec3(40, 1.5, 1), forward, Vec3::UnitZ(), 0.87, 1.78, forward};
  std::size_t seen = 0;
  std::size_t unseen = 0;
  for (int i = 0; i < 30; ++i) {
    stage.world.step(input);
    for (const Contact& contact : stage.world.contacts()) {
      if (contact.level > 0) ++(contact.point_m.x() > 0 ? seen : unseen);
    }
  }
  EXPECT_GT(seen, 10 * std::max<std::size_t>(unseen, 1));
}

TEST(Capacity, AFullFrontLeavesThePairAtItsLevelAndIsCounted) {
  std::uint64_t expected = 0;
  for (const int threads : {1, 3}) {
    WorldSettings settings = falling();
    settings.max_front_entries = 1024;
    settings.threads = threads;
    Stage stage(settings, 0.2);
    stage.jacks(120, 5);
    std::size_t full = 0;
    for (int i = 0; i < 90; ++i) {
      StepInput input = step_of(1.0 / 60);
      input.budget = Budget::work(1'000'000'000);
      full += stage.world.step(input).fronts_full;
    }
    EXPECT_GT(full, 0U);
    for (const BodyId body : stage.bodies) EXPECT_GT(stage.at(body).position_m.z(), 0);
    if (expected == 0) expected = stage.world.state_hash();
    EXPECT_EQ(stage.world.state_hash(), expected) << "which fronts were refused must not depend on threads";
  }
}

// Many waiting fronts of few entries: a pool has room for fewer of them than for their entries.
TEST(Capacity, ManyShortFrontsAreRefusedAlikeOnAnyNumberOfThreads) {
  std::vector<Sphere> balls;
  for (int i = 0; i < 512; ++i) balls.push_back({Vec3((i - 255.5) * 2.0 / 512, 0, 0), 0.02});
  const ShapePtr rod = make_spheres_shape(balls).value();
  std::uint64_t expected = 0;
  for (const int threads : {1, 2, 3}) {
    WorldSettings settings = falling();
    settings.max_front_entries = 4096;
    settings.threads = threads;
    Stage stage(settings, 0.2);
    stage.tray(5);
    const ShapeId shape = stage.world.add_shape(rod);
    std::mt19937_64 random(7);
    const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-53 - 0.5; };
    for (int i = 0; i < 160; ++i) {
      // Layer on layer, each across the one below it.
      const bool across = i / 16 % 2 != 0;
      const double along_m = 0.12 * (i % 16 - 7.5);
      const double height_m = 0.03 + 0.04 * (i / 16);
      Vec3 velocity = Vec3::Zero();
      for (double& part : velocity) part = 0.1 * unit();
      stage.add(shape, across ? Vec3(along_m, 0, height_m) : Vec3(0, along_m, height_m), velocity, Vec3::Zero(),
                across ? Quat(std::sqrt(0.5), 0, 0, std::sqrt(0.5)) : Quat(1, 0, 0, 0));
    }
    std::size_t full = 0;
    StepInput input = step_of(1.0 / 60);
    input.budget = Budget::work(1'000'000'000);
    for (int i = 0; i < 10; ++i) full += stage.world.step(input).fronts_full;
    EXPECT_GT(full, 0U);
    if (expected == 0) expected = stage.world.state_hash();
    EXPECT_EQ(stage.world.state_hash(), expected) << threads;
  }
}

TEST(Capacity, FrontsThatWaitForTheirTurnFillNoPoolUnderADeadline) {
  WorldSettings settings = falling();
  settings.max_front_entries = 512;  // less than the first levels of all pairs
  settings.threads = 1;
  settings.policy.kind = scheduler::PolicyKind::EqualLevels;  // each pair to its first level before any goes on
  Stage stage(settings, 0.2);
  stage.jacks(300, 5);
  std::size_t ranked = 0;
  for (int i = 0; i < 90; ++i) {
    simulation::WorldAccess::of(stage.world).forecasts.pair_cost.in_order_ns = 1e18;
    StepInput input = step_of(1.0 / 60);
    input.budget = Budget::within(std::chrono::minutes(1));
    const FrameReport report = stage.world.step(input);
    EXPECT_EQ(report.fronts_full, 0U);
    EXPECT_EQ(report.pairs_left, 0U);
    ranked += report.pairs_ranked;
  }
  EXPECT_GT(ranked, 0U);
}

TEST(Capacity, AFullFrontUnderADeadlineIsCountedToo) {
  WorldSettings settings = falling();
  settings.max_front_entries = 64;  // less than one pair of boxes needs that lie on each other
  settings.threads = 1;
  for (const bool in_order : {true, false}) {
    Stage stage(settings, 0.2);
    stage.plane(Vec3::UnitZ(), 0);
    const ShapeId box = stage.world.add_shape(
        make_mesh_shape(test::box_mesh(Vec3(0.6, 0.6, 0.6)), {.depth = 3, .preset = TreePreset::Fast}).value());
    for (int i = 0; i < 8; ++i) stage.add(box, Vec3(0.1 * i, 0, 0.35 + 0.62 * i));
    std::size_t full = 0;
    for (int i = 0; i < 30; ++i) {
      simulation::WorldAccess::of(stage.world).forecasts.pair_cost.in_order_ns = in_order ? 1 : 1e18;
      StepInput input = step_of(1.0 / 60);
      input.budget = Budget::within(std::chrono::minutes(1));
      full += stage.world.step(input).fronts_full;
    }
    EXPECT_GT(full, 0U) << in_order;
  }
}

TEST(Capacity, PartnersBeyondTheLimitAreCounted) {
  WorldSettings settings;
  settings.max_partners = 4;
  Stage stage(settings, 0);
  const ShapeId ball = stage.ball(0.5);
  for (int i = 0; i < 30; ++i) stage.add(ball, Vec3(0.01 * i, 0, 0));
  EXPECT_GT(stage.world.step(step_of(0.01)).pairs_discarded, 0U);
}

TEST(Capacity, ContactsBeyondTheLastColourAreStillAnswered) {
  WorldSettings settings;
  Stage stage(settings, 0);
  const ShapeId small = stage.ball(0.1);
  stage.add(stage.ball(5), Vec3::Zero());
  // A hundred balls around the one in the middle, moving toward it.
  for (int i = 0; i < 100; ++i) {
    const double z = -1 + (2.0 * i + 1) / 100;
    const double angle = 2.39996322972865332 * i;
    const Vec3 direction(std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z);
    stage.add(small, 5.1 * direction, -direction);
  }
  const FrameReport report = stage.world.step(step_of(0.01));
  EXPECT_EQ(report.contact_pairs, 100U);
  EXPECT_EQ(report.colors_full, 44U) << "of 64 colours eight are for the ground";
  for (std::size_t i = 1; i < stage.bodies.size(); ++i) {
    EXPECT_LT(stage.at(stage.bodies[i]).velocity_mps.norm(), 0.1);
  }
}

}  // namespace
}  // namespace poise
