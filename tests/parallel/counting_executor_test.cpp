// SPDX-License-Identifier: MIT
#include "parallel/counting_executor.h"

#include <gtest/gtest.h>

#include <vector>

namespace poise::parallel {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;

/// A clock that moves only when work is done.
struct Invented {
  CountedAt now;
  void work(int ns) {
    now.work += nanoseconds(ns);
    now.wall += nanoseconds(ns);
  }
  /// Another program has the processor.
  void lose(int ns) { now.wall += nanoseconds(ns); }
  CountingExecutor executor(int cores) {
    return CountingExecutor(cores, [this] { return now; });
  }
};

TEST(CountingExecutor, CountsEachChunkAndTheLongest) {
  Invented time;
  CountingExecutor executor = time.executor(2);
  const std::vector<int> cost_ns = {5, 1, 1, 7, 2};
  std::vector<std::size_t> seen;
  parallel_for(executor, cost_ns.size(), 1, [&](std::size_t begin, std::size_t, int worker) {
    EXPECT_EQ(worker, 0);
    seen.push_back(begin);
    time.work(cost_ns[begin]);
  });
  EXPECT_EQ(seen, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
  ASSERT_EQ(executor.loops().size(), 1U);
  const CountedLoop& loop = executor.loops()[0];
  EXPECT_EQ(loop.chunks, 5U);
  EXPECT_EQ(loop.work.count(), 16);
  EXPECT_EQ(loop.longest.count(), 7);
  // 5 | 1 1 7, then 2 on the core that is free after 5.
  EXPECT_EQ(loop.on_cores.count(), 9);
}

TEST(CountingExecutor, WorkBetweenLoopsIsSerialAndALoopOfOneChunkToo) {
  Invented time;
  CountingExecutor executor = time.executor(4);
  const CountedAt start = executor.now();
  time.work(10);
  parallel_for(executor, 3, 1, [&](std::size_t, std::size_t, int) { time.work(20); });
  time.work(1);
  parallel_for(executor, 3, 8, [&](std::size_t, std::size_t, int) { time.work(4); });
  const CountedAt end = executor.now();
  const std::vector<steady_clock::time_point> borders = {start.wall, end.wall};
  const std::vector<CountedWork> counted = count_stretches(executor.loops(), start, end, borders);
  ASSERT_EQ(counted.size(), 1U);
  EXPECT_EQ(counted[0].work.count(), 75);
  EXPECT_EQ(counted[0].serial.count(), 15);
  EXPECT_EQ(counted[0].span.count(), 35);
  EXPECT_EQ(counted[0].on_cores.count(), 35);
  EXPECT_EQ(counted[0].loops, 1U);
}

TEST(CountingExecutor, ANestedLoopIsWorkOfItsChunk) {
  Invented time;
  CountingExecutor executor = time.executor(2);
  parallel_for(executor, 2, 1, [&](std::size_t, std::size_t, int) {
    parallel_for(executor, 3, 1, [&](std::size_t, std::size_t, int) { time.work(1); });
  });
  ASSERT_EQ(executor.loops().size(), 1U);
  EXPECT_EQ(executor.loops()[0].longest.count(), 3);
  executor.clear();
  EXPECT_TRUE(executor.loops().empty());
}

TEST(CountStretches, DividesSerialWorkAtTheBordersAndCountsNoLostTime) {
  Invented time;
  CountingExecutor executor = time.executor(2);
  const CountedAt start = executor.now();
  time.work(4);
  const steady_clock::time_point border = executor.now().wall;
  time.work(12);
  parallel_for(executor, 2, 1, [&](std::size_t chunk, std::size_t, int) {
    time.work(10);
    if (chunk == 1) time.lose(1000);
  });
  time.work(3);
  const CountedAt end = executor.now();
  const std::vector<CountedWork> counted = count_stretches(
      executor.loops(), start, end, std::vector<steady_clock::time_point>{start.wall, border, end.wall});
  ASSERT_EQ(counted.size(), 2U);
  EXPECT_EQ(counted[0].work.count(), 4);
  EXPECT_EQ(counted[0].loops, 0U);
  EXPECT_EQ(counted[1].serial.count(), 15);
  EXPECT_EQ(counted[1].work.count(), 35);
  EXPECT_EQ(counted[1].span.count(), 25);
  EXPECT_EQ(counted[1].on_cores.count(), 25);
}

}  // namespace
}  // namespace poise::parallel
