// SPDX-License-Identifier: MIT
#include "frame/refine/rank.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "frame/refine/open_refinement.h"
#include "frame/scenes.h"
#include "verify/world_access.h"

namespace poise {
namespace {

using simulation::WorldAccess;
using simulation::WorldState;

// Its clock goes on by as much with each look.
class TickingExecutor final : public parallel::Executor {
 public:
  explicit TickingExecutor(Nanoseconds tick) : tick_(tick) {}
  [[nodiscard]] int concurrency() const override { return 1; }
  void run(parallel::WorkerFunction step) override {
    while (step(0)) {
    }
  }
  std::size_t run_with(const parallel::Patience& /*patience*/, parallel::WorkerFunction step) override {
    run(step);
    return 0;
  }
  [[nodiscard]] bool commit(int /*worker*/) override { return true; }
  void settle() override {}
  [[nodiscard]] SteadyClock::time_point time() const override { return now_ += tick_; }

 private:
  Nanoseconds tick_;
  mutable SteadyClock::time_point now_{};
};

// Jacks that have landed, and what ranking finds of them with an hour for it where each look at the clock takes a
// while.
class RankPairs : public ::testing::Test {
 protected:
  RankPairs() : stage_(settings()) {
    stage_.jacks(500, 6);
    // Nothing is known of them.
    input_.budget = Budget::work(0);
    for (int frame = 0; frame < 100; ++frame) stage_.world.step(input_);
  }
  static WorldSettings settings() {
    WorldSettings settings;
    settings.threads = 1;
    settings.gravity_mps2 = Vec3(0, 0, -9.81);
    return settings;
  }
  FrameReport rank(Nanoseconds tick) {
    WorldState& world = WorldAccess::of(stage_.world);
    simulation::CompletedLevels& levels = world.outputs.levels;
    TickingExecutor executor(tick);
    simulation::begin_levels(world.outputs.table, levels, executor);
    const simulation::RefineInput refine{world.scene(),         simulation::terms_of(world.settings, input_),
                                         world.outputs.motion,  world.outputs.table,
                                         world.settings.policy, input_};
    world.forecasts.rank_cost_ns = 1;
    FrameReport report;
    const SteadyClock::time_point start = executor.time();
    EXPECT_TRUE(simulation::rank_pairs(refine,
                                       {world.pools, world.forecasts, world.bands, world.rounds, world.open,
                                        world.learned, world.prepared_cues, world.cache.points},
                                       simulation::frame_facts(refine), start, start + std::chrono::hours(2), levels,
                                       report, executor));
    return report;
  }
  // All pairs in the order of their turns.
  std::vector<std::uint32_t> order() {
    std::vector<std::uint32_t> pairs;
    simulation::TurnOrder& turns = WorldAccess::of(stage_.world).open.turns;
    for (auto block = turns.take(1, 1); block.begin < block.end; block = turns.take(1, 1)) {
      EXPECT_EQ(turns.turn_at(block.begin), turn_of(turns.pair_at(block.begin)));
      pairs.push_back(turns.pair_at(block.begin));
    }
    return pairs;
  }
  std::uint32_t turn_of(std::uint32_t pair) {
    const simulation::PairProgress& progress = WorldAccess::of(stage_.world).outputs.levels.progress[pair];
    return progress.ranked ? progress.turn : kLastTurn;
  }
  [[nodiscard]] std::vector<std::uint32_t> refinable() {
    std::vector<std::uint32_t> pairs;
    const auto& progress = WorldAccess::of(stage_.world).outputs.levels.progress;
    for (std::uint32_t i = 0; i < progress.size(); ++i) {
      if (progress[i].refinable()) pairs.push_back(i);
    }
    return pairs;
  }

  // Where those have their turn that are not ranked now: where the others are in the mean, as they never were.
  std::uint32_t kLastTurn = 0;
  Stage stage_;
  StepInput input_ = step_of(1.0 / 60);
};

TEST_F(RankPairs, GivesAllPairsTheirTurns) {
  const FrameReport report = rank(Nanoseconds(1));
  std::vector<std::uint32_t> pairs = order();
  EXPECT_EQ(report.pairs_ranked, pairs.size());
  EXPECT_GT(pairs.size(), 500U);
  for (std::size_t i = 1; i < pairs.size(); ++i) EXPECT_GE(turn_of(pairs[i - 1]), turn_of(pairs[i]));
  std::ranges::sort(pairs);
  EXPECT_EQ(pairs, refinable());
}

TEST_F(RankPairs, EndsWhenItsTimeIsOverAndTheOthersHaveATurnAllTheSame) {
  // Six looks in an hour, which is its part of two.
  const FrameReport report = rank(std::chrono::minutes(10));
  EXPECT_GT(report.pairs_ranked, 128U);
  const auto& progress = WorldAccess::of(stage_.world).outputs.levels.progress;
  std::uint64_t bands = 0;
  for (const std::uint32_t pair : refinable()) bands += progress[pair].ranked ? progress[pair].turn : 0U;
  kLastTurn = static_cast<std::uint32_t>(bands / report.pairs_ranked);
  std::vector<std::uint32_t> pairs = order();
  EXPECT_LT(report.pairs_ranked, pairs.size());
  std::ranges::sort(pairs);
  EXPECT_EQ(pairs, refinable());
}

}  // namespace
}  // namespace poise
