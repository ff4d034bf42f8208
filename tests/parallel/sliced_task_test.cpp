// SPDX-License-Identifier: MIT
#include "parallel/sliced_task.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <new>
#include <numeric>
#include <thread>
#include <utility>
#include <vector>

namespace poise::parallel {
namespace {

using Clock = SlicedTask::Clock;

// A time that has passed: a slice of it does one item at least, and on some workers one each.
constexpr Clock::time_point kOver{};

class SlicedTasks : public ::testing::TestWithParam<std::pair<ExecutorKind, int>> {
 protected:
  std::unique_ptr<Executor> workers = make_executor(GetParam().first, GetParam().second);
};

TEST_P(SlicedTasks, DoesEachItemOnceInHoweverManySlices) {
  SlicedTask task(*workers);
  std::vector<int> done(1000, 0);
  ASSERT_TRUE(task.begin([&] {
    for (int loop = 0; loop < 3; ++loop) {
      parallel_for(task.executor(), done.size(), 10, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) ++done[i];
      });
    }
  }));
  EXPECT_TRUE(task.unfinished());
  int slices = 1;
  int before = 0;
  while (!task.run_until(kOver)) {
    ++slices;
    // Read while nobody works: that is what the thread sanitizer looks at.
    const int now = std::accumulate(done.begin(), done.end(), 0);
    EXPECT_GT(now, before);
    before = now;
  }
  EXPECT_FALSE(task.unfinished());
  EXPECT_GE(slices, 3 * 100 / GetParam().second) << "an item a worker and slice";
  EXPECT_LE(slices, 3 * 101 + 1);
  for (const int times : done) EXPECT_EQ(times, 3);
}

TEST_P(SlicedTasks, WhatTheFunctionThrowsComesOutOfItsSlice) {
  SlicedTask task(*workers);
  const auto no_memory = [&] {
    task.executor().stop_point();
    task.executor().stop_point();
    throw std::bad_alloc();
  };
  ASSERT_TRUE(task.begin(no_memory));
  EXPECT_FALSE(task.run_until(kOver)) << "a slice goes beyond one point at least, not beyond two";
  EXPECT_THROW(task.run_until(Clock::time_point::max()), std::bad_alloc);
  EXPECT_FALSE(task.unfinished());
  bool ran = false;
  ASSERT_TRUE(task.begin([&] { ran = true; }));
  EXPECT_TRUE(task.run_until(Clock::time_point::max()));
  EXPECT_TRUE(ran);
  // Nobody asks for it any more.
  ASSERT_TRUE(task.begin(no_memory));
}

TEST_P(SlicedTasks, EndsInOneSliceWhereThereIsTime) {
  SlicedTask task(*workers);
  std::atomic<int> items{0};
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(
        task.begin([&] { parallel_for(task.executor(), 100, 1, [&](std::size_t, std::size_t, int) { ++items; }); }));
    EXPECT_TRUE(task.run_until(Clock::time_point::max()));
    EXPECT_EQ(items.load(), 100 * (round + 1));
  }
}

TEST_P(SlicedTasks, ItsClockStandsStillBetweenSlices) {
  SlicedTask task(*workers);
  Clock::time_point begun, ended;
  ASSERT_TRUE(task.begin([&] {
    begun = task.executor().time();
    parallel_for(task.executor(), 20, 1, [&](std::size_t, std::size_t, int) {});
    ended = task.executor().time();
  }));
  const Clock::time_point before = Clock::now();
  constexpr std::chrono::milliseconds kPause{2};
  int pauses = 0;
  while (!task.run_until(kOver)) {
    std::this_thread::sleep_for(kPause);
    ++pauses;
  }
  ASSERT_GT(pauses, 5);
  EXPECT_LE(ended - begun, (Clock::now() - before) - pauses * kPause);
  EXPECT_GE(ended, begun);
}

TEST_P(SlicedTasks, StopsAtStopPointsBetweenLoops) {
  SlicedTask task(*workers);
  constexpr std::size_t kItems = 20;
  std::vector<std::size_t> done;
  ASSERT_TRUE(task.begin(
      [&] { serial_for(task.executor(), kItems, 1, [&](std::size_t begin, std::size_t) { done.push_back(begin); }); }));
  std::size_t slices = 0;
  while (task.unfinished()) {
    const std::size_t before = done.size();
    // Over before it begins: what lies before one stop point is done, and after that it stops at the next.
    task.run_until(Clock::now());
    ++slices;
    EXPECT_LE(done.size(), before + 2);
    ASSERT_LE(slices, 2 * kItems);
  }
  EXPECT_EQ(done.size(), kItems);
  EXPECT_GE(slices, kItems / 2);
}

TEST_P(SlicedTasks, StopsTheEarlierTheFewerMayBeLate) {
  // How much earlier after so many slices that were late.
  const auto lead_after = [&](int slices, std::chrono::nanoseconds length, double late) {
    std::atomic<Clock::time_point> until{};  // lives until the task has ended
    SlicedTask task(*workers);
    EXPECT_TRUE(task.begin([&] {
      serial_for(task.executor(), 1000, 1, [&](std::size_t, std::size_t) {
        while (Clock::now() <= until.load()) std::this_thread::yield();
      });
    }));
    for (int i = 0; i < slices; ++i) {
      until = Clock::now() + length;
      EXPECT_FALSE(task.run_until(until, late));
    }
    return task.lead();
  };
  using namespace std::chrono_literals;
  // A slice that was late adds a tenth of a millisecond; less where the system has left too little of it.
  for (const auto& [late, first] :
       {std::pair(0.2, 500us), std::pair(0.01, 500us), std::pair(0.001, 1000us), std::pair(1e-6, 2500us)}) {
    const auto lead = lead_after(1, 20ms, late);
    EXPECT_GE(lead, first) << late;
    EXPECT_LE(lead, first + 100us) << late;
  }
  EXPECT_GT(lead_after(5, 20ms, 0.01), 500us);
  EXPECT_LE(lead_after(8, 4ms, 0.01), 1ms) << "a quarter of the slice";
}

// The stop points of a part that is an item itself, as where another loop is inside.
TEST_P(SlicedTasks, AStopPointWithinAnItemIsNone) {
  SlicedTask task(*workers);
  std::atomic<int> inner{0};
  ASSERT_TRUE(task.begin([&] {
    parallel_for(task.executor(), 4, 1, [&](std::size_t, std::size_t, int) {
      serial_for(task.executor(), 10, 1, [&](std::size_t, std::size_t) { ++inner; });
    });
  }));
  std::size_t slices = 0;
  while (task.unfinished()) {
    task.run_until(Clock::now());
    ++slices;
    EXPECT_EQ(inner % 10, 0);
    ASSERT_LE(slices, 10U);
  }
  EXPECT_EQ(inner, 40);
}

TEST_P(SlicedTasks, ALoopWithinAnItemIsAPartOfIt) {
  SlicedTask task(*workers);
  std::atomic<int> inner{0};
  std::atomic<int> outer{0};
  ASSERT_TRUE(task.begin([&] {
    parallel_for(task.executor(), 8, 1, [&](std::size_t, std::size_t, int) {
      parallel_for(task.executor(), 50, 1, [&](std::size_t, std::size_t, int) { ++inner; });
      ++outer;
    });
  }));
  while (!task.run_until(kOver)) EXPECT_EQ(inner.load(), 50 * outer.load());
  EXPECT_EQ(inner.load(), 8 * 50);
}

TEST_P(SlicedTasks, WhatIsUnfinishedEndsBeforeItGoes) {
  std::atomic<int> items{0};
  {
    SlicedTask task(*workers);
    ASSERT_TRUE(
        task.begin([&] { parallel_for(task.executor(), 100, 1, [&](std::size_t, std::size_t, int) { ++items; }); }));
    task.run_until(kOver);
    EXPECT_LT(items.load(), 100);
  }
  EXPECT_EQ(items.load(), 100);
}

TEST_P(SlicedTasks, BetweenSlicesTheWorkersAreTheCallers) {
  SlicedTask task(*workers);
  std::atomic<int> items{0};
  std::atomic<int> own{0};
  ASSERT_TRUE(
      task.begin([&] { parallel_for(task.executor(), 50, 1, [&](std::size_t, std::size_t, int) { ++items; }); }));
  int loops = 0;
  while (!task.run_until(kOver)) {
    parallel_for(*workers, 20, 1, [&](std::size_t, std::size_t, int) { ++own; });
    ++loops;
    EXPECT_EQ(own.load(), 20 * loops);
  }
  EXPECT_EQ(items.load(), 50);
}

INSTANTIATE_TEST_SUITE_P(Executors, SlicedTasks,
                         ::testing::Values(std::pair(ExecutorKind::Serial, 1), std::pair(ExecutorKind::Threads, 2),
                                           std::pair(ExecutorKind::Threads, 4), std::pair(ExecutorKind::Tbb, 2)));

}  // namespace
}  // namespace poise::parallel
