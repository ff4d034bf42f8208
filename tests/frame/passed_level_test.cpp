// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <vector>

#include "collision/shapes.h"
#include "frame/refine/refine_level.h"
#include "frame/scenes.h"
#include "verify/world_access.h"

namespace poise::simulation {
namespace {

using collision::FrontPool;
using collision::LevelContact;

void expect_same(const LevelContact& found, const LevelContact& expected) {
  EXPECT_FALSE(found.gaps_only);
  EXPECT_EQ(found.contact.present, expected.contact.present);
  EXPECT_EQ(found.contact.estimated_separation_m, expected.contact.estimated_separation_m);
  EXPECT_EQ(found.contact.certain_separation_m, expected.contact.certain_separation_m);
  EXPECT_EQ(found.contact.direction, expected.contact.direction);
  EXPECT_EQ(found.contact.arm_m, expected.contact.arm_m);
  EXPECT_EQ(found.contact.moment_a_m, expected.contact.moment_a_m);
  EXPECT_EQ(found.contact.moment_b_m, expected.contact.moment_b_m);
  EXPECT_EQ(found.reach_m, expected.reach_m);
  EXPECT_EQ(found.narrowed, expected.narrowed);
  EXPECT_EQ(found.points_due, expected.points_due);
  ASSERT_EQ(found.manifold_points.count, expected.manifold_points.count);
  for (std::size_t k = 0; k < expected.manifold_points.count; ++k) {
    EXPECT_EQ(found.manifold_points.point[k].point_m, expected.manifold_points.point[k].point_m);
    EXPECT_EQ(found.manifold_points.point[k].normal, expected.manifold_points.point[k].normal);
  }
}

// Jacks and worms of 150 balls, whose trees have three levels, on their way down; nothing is known of their pairs.
class PassedLevels : public ::testing::Test {
 protected:
  PassedLevels() : stage_(one_thread_with_gravity()) {
    stage_.jacks(60, 6);
    const ShapeId worm = stage_.world.add_shape(collision::make_worm(150));
    for (int i = 0; i < 60; ++i) stage_.add(worm, Vec3(i % 5 - 2, i / 5 % 4 - 1.5, 12 + 0.8 * (i / 20)));
    StepInput input = step_of(1.0 / 60);
    input.budget = Budget::work(0);
    for (int frame = 0; frame < 90; ++frame) stage_.world.step(input);
  }
  // Calls visit(posed pair, its progress before its first level) for each pair that has levels.
  template <class Visit>
  void for_each_pair(Visit&& visit) {
    const WorldState& world = WorldAccess::of(stage_.world);
    const PairTable& table = world.outputs.table;
    for (std::size_t i = 0; i < table.size(); ++i) {
      const PairProgress progress(table.start[i]);
      if (progress.refinable()) visit(posed(world.outputs.motion, table.pairs[i]), progress);
    }
  }
  [[nodiscard]] PairRefiner refiner() { return {WorldAccess::of(stage_.world).scene()}; }

  Stage stage_;
};

TEST_F(PassedLevels, SayWhatTheNextOneReadsAndAreCompletedToTheBit) {
  const PairRefiner refiner = this->refiner();
  int completed = 0;
  int deep = 0;
  for_each_pair([&](const PosedPair& pair, const PairProgress& before) {
    std::vector<FrontPool> pools;
    pools.emplace_back(1U << 16U);
    std::vector<FrontPool> others;
    others.emplace_back(1U << 16U);
    collision::PairFrame frame = frame_of(refiner, pair);
    PairProgress whole = before;
    PairProgress passing = before;
    LevelContact expected;
    LevelContact found;
    while (whole.refinable()) {
      const bool passes = whole.level.passes_next();
      const PassedLevel passed(passing.level, found, others[0]);
      ASSERT_EQ(refine_level(refiner, pair, frame, whole, expected, pools, 0), Outcome::Completed);
      ASSERT_EQ(refine_level(refiner, pair, frame, passing, found, others, 0, Followed::AtOnce), Outcome::Completed);
      ASSERT_EQ(passing.level.apart, whole.level.apart);
      ASSERT_EQ(passing.level.front_entries, whole.level.front_entries);
      ASSERT_EQ(found.gaps_only, passes && !whole.level.apart);
      if (!found.gaps_only) continue;
      EXPECT_EQ(found.contact.estimated_separation_m, expected.contact.estimated_separation_m);
      EXPECT_EQ(found.contact.certain_separation_m, expected.contact.certain_separation_m);
      EXPECT_EQ(found.reach_m, expected.reach_m);
      EXPECT_EQ(found.narrowed, expected.narrowed);
      // As if the next one had not come to its end.
      PairProgress stopped = passing;
      LevelContact again = found;
      passed.complete(refiner, others, pair, frame, stopped.level, again, 0);
      expect_same(again, expected);
      EXPECT_EQ(stopped.level.front_entries, whole.level.front_entries);
      passing = stopped;
      ++completed;
      if (whole.level.level > 1) ++deep;
    }
    if (!whole.level.apart) expect_same(found, expected);
  });
  EXPECT_GT(completed, 200);
  EXPECT_GT(deep, 20);
}

TEST_F(PassedLevels, AreCompletedWhereTheNextFrontDoesNotFit) {
  const PairRefiner refiner = this->refiner();
  int full = 0;
  for_each_pair([&](const PosedPair& pair, const PairProgress& before) {
    // Room for the front of a level of one expansion, and not for that of the next.
    std::vector<FrontPool> small;
    small.emplace_back(kTreeBranching * kTreeBranching);
    std::vector<FrontPool> pools;
    pools.emplace_back(1U << 16U);
    PairProgress progress = before;
    LevelContact found;
    if (refine_pair(refiner, pair, progress, found, small, 0, [](std::uint64_t, Outcome) {})) return;
    ++full;
    PairProgress expected_progress = before;
    LevelContact expected;
    collision::PairFrame frame = frame_of(refiner, pair);
    while (expected_progress.level.level < progress.level.level)
      refine_level(refiner, pair, frame, expected_progress, expected, pools, 0);
    make_points_due(refiner, pair, expected_progress, expected, pools);
    expect_same(found, expected);
  });
  EXPECT_GT(full, 100);
}

// One thread, for which all time is over from some look at the clock within refinement on.
class StoppedClock final : public parallel::Executor {
 public:
  int last_look = 0;

  [[nodiscard]] int concurrency() const override { return 1; }
  void run(parallel::WorkerFunction step) override {
    while (step(0)) {
    }
  }
  std::size_t run_with(const parallel::Patience& /*patience*/, parallel::WorkerFunction step) override {
    looks_ = 0;
    refines_ = true;
    run(step);
    refines_ = false;
    return 0;
  }
  [[nodiscard]] bool commit(int /*worker*/) override { return true; }
  void settle() override {}
  [[nodiscard]] SteadyClock::time_point time() const override {
    const bool over = refines_ && ++looks_ > last_look;
    return SteadyClock::now() + (over ? std::chrono::hours(2) : std::chrono::hours(0));
  }

 private:
  bool refines_ = false;
  mutable int looks_ = 0;  // a step that is recorded looks after each level
};

// Where time is over between two levels of a pair, it stays at the first of them with all that is to be found of it: as
// in a replay, which does levels one by one.
TEST(PassedLevel, IsDoneWholeWhereTimeIsOverBeforeTheNextOne) {
  for (const double in_order_ns : {1e-9, 1e18}) {
    Stage recorded(one_thread_with_gravity(), 0.2);
    Stage replayed(one_thread_with_gravity(), 0.2);
    for (Stage* stage : {&recorded, &replayed}) stage->jacks(60, 4);
    WorldState& world = WorldAccess::of(recorded.world);
    auto made = std::make_unique<StoppedClock>();
    StoppedClock& clock = *made;
    world.executor = std::move(made);
    StepInput input = step_of(1.0 / 60);
    input.record = true;
    std::uint32_t passed = 0;
    for (int frame = 0; frame < 90; ++frame) {
      clock.last_look = 1 + frame % 40;
      world.forecasts.pair_cost.in_order_ns = in_order_ns;
      input.budget = Budget::within(std::chrono::hours(1));
      passed += recorded.world.step(input).level_histogram[1];
      FrameDecisions decisions;
      recorded.world.decisions(decisions);
      StepInput again = step_of(1.0 / 60);
      again.replay = &decisions;
      ASSERT_EQ(replayed.world.step(again).status, StepStatus::Done);
      ASSERT_EQ(replayed.world.state_hash(), recorded.world.state_hash()) << "frame " << frame << ", " << in_order_ns;
    }
    EXPECT_GT(passed, 10U) << in_order_ns;
  }
}

}  // namespace
}  // namespace poise::simulation
