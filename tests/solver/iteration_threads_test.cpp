// SPDX-License-Identifier: MIT
#include "solver/iterations/iteration_threads.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "solver/contact_bench.h"

namespace poise::solver {
namespace {

using std::chrono::nanoseconds;

// What iterations take on a machine.
struct Machine {
  nanoseconds alone, all;
  nanoseconds cold{0};  // more, for the first after a change from one way to the other
};

// Makes the iterations of a step; says of each whether it was made alone.
std::vector<bool> step(IterationThreads& threads, const Machine& machine, int iterations, bool choice = true) {
  std::vector<bool> made;
  threads.begin(choice);
  for (int i = 0; i < iterations; ++i) {
    const bool alone = threads.alone();
    const bool changed = !made.empty() && made.back() != alone;
    if (threads.measures())
      threads.note((alone ? machine.alone : machine.all) + (changed ? machine.cold : nanoseconds(0)));
    made.push_back(alone);
  }
  return made;
}

constexpr int kTrials = IterationThreads::kTrials;

TEST(IterationThreads, GoesTheWayThatTookLessTime) {
  for (const bool alone : {true, false}) {
    IterationThreads threads;
    const Machine machine{nanoseconds(alone ? 5 : 9), nanoseconds(7)};
    const std::vector<bool> first = step(threads, machine, 20);
    for (int i = 0; i < 20; ++i) {
      const bool expected = i < kTrials || (i >= 2 * kTrials && alone);
      EXPECT_EQ(first[static_cast<std::size_t>(i)], expected) << i;
    }
    EXPECT_EQ(step(threads, machine, 4), std::vector<bool>(4, alone)) << "and stays there";
  }
}

TEST(IterationThreads, StaysWithAllThreadsWhereAloneSavesLittle) {
  IterationThreads threads;
  step(threads, {nanoseconds(91), nanoseconds(100)}, 20);
  EXPECT_FALSE(threads.alone());
  IterationThreads others;
  step(others, {nanoseconds(89), nanoseconds(100)}, 20);
  EXPECT_TRUE(others.alone());
}

TEST(IterationThreads, DoesNotTimeTheFirstIterationAfterAChange) {
  IterationThreads threads;
  const Machine machine{nanoseconds(9), nanoseconds(7), nanoseconds(100)};
  step(threads, machine, 2 * kTrials);
  EXPECT_FALSE(threads.alone()) << "the first by all found cold caches";
}

TEST(IterationThreads, MeasuresAgainAfterSomeSteps) {
  IterationThreads threads;
  step(threads, {nanoseconds(5), nanoseconds(7)}, 20);
  const Machine later{nanoseconds(9), nanoseconds(7)};
  for (std::uint32_t k = 1; k < IterationThreads::kSteps; ++k) {
    ASSERT_EQ(step(threads, later, 2), std::vector<bool>(2, true)) << k;
    ASSERT_FALSE(threads.measures());
  }
  step(threads, later, 20);
  EXPECT_EQ(step(threads, later, 3), std::vector<bool>(3, false));
}

TEST(IterationThreads, GoesOnMeasuringInTheNextStep) {
  IterationThreads threads;
  const Machine machine{nanoseconds(5), nanoseconds(7)};
  std::vector<bool> made;
  for (int k = 0; k < 4; ++k) {
    for (const bool alone : step(threads, machine, 2)) made.push_back(alone);
  }
  EXPECT_EQ(made, (std::vector<bool>{true, true, true, false, false, false, true, true}));
}

TEST(IterationThreads, WithoutAChoiceNothingIsAloneOrMeasured) {
  IterationThreads threads;
  step(threads, {nanoseconds(5), nanoseconds(7)}, 20);
  ASSERT_TRUE(threads.alone());
  for (std::uint32_t k = 0; k < 2 * IterationThreads::kSteps; ++k) {
    ASSERT_EQ(step(threads, {}, 3, false), std::vector<bool>(3, false));
    ASSERT_FALSE(threads.measures());
  }
  threads.begin(true);
  EXPECT_TRUE(threads.alone()) << "what was measured still holds";
}

// Four workers of which one does all, on a clock of its own: loops of all workers take one time, and parts of loops of
// the calling thread alone another.
class Clocked final : public parallel::Executor {
 public:
  Clocked(nanoseconds run, nanoseconds part) : run_(run), part_(part) {}
  [[nodiscard]] int concurrency() const override { return 4; }
  void run(parallel::WorkerFunction step) override {
    ++runs;
    now_ += run_;
    while (step(0)) {
    }
  }
  std::size_t run_with(const parallel::Patience& /*patience*/, parallel::WorkerFunction step) override {
    run(step);
    return 0;
  }
  [[nodiscard]] bool commit(int /*worker*/) override { return true; }
  void settle() override {}
  void stop_point() override {
    ++parts;
    now_ += part_;
  }
  [[nodiscard]] std::chrono::steady_clock::time_point time() const override { return now_; }

  int runs = 0, parts = 0;

 private:
  nanoseconds run_, part_;
  std::chrono::steady_clock::time_point now_;
};

TEST(IterationThreads, TheContactSolverGoesTheQuickerWay) {
  for (const bool alone : {true, false}) {
    Clocked executor(nanoseconds(alone ? 900 : 100), nanoseconds(500));
    Bench bench;
    bench.settings.gravity_mps2 = Vec3(0, 0, -9.81);
    const std::uint32_t floor = bench.add_body(0);
    for (int i = 0; i < 60; ++i) {
      const Vec3 place(3.0 * i, 0, 0);
      const std::uint32_t body = bench.add_body(1, place);
      bench.add_pair(floor, body, Vec3::UnitZ(), {place + Vec3(0.5, 0.5, -0.5), place + Vec3(-0.5, 0.4, -0.5)});
    }
    const auto step = [&] { bench.solver.solve(bench.system(), bench.settings, executor); };
    for (int i = 0; i < 10; ++i) step();
    EXPECT_GT(executor.parts, 0) << "both ways were tried";
    EXPECT_GT(executor.runs, 0);
    executor.runs = executor.parts = 0;
    for (int i = 0; i < 5; ++i) step();
    EXPECT_EQ(executor.parts > 0, alone);
    EXPECT_EQ(executor.runs == 0, alone) << executor.runs;
  }
}

}  // namespace
}  // namespace poise::solver
