// SPDX-License-Identifier: MIT
#include "poise/scheduler/refine_until.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>
#include <thread>
#include <vector>

namespace poise::scheduler {
namespace {

using std::chrono::microseconds;
using Kind = JobOutcome::Kind;

// All times are invented.
const TimePoint kStart{std::chrono::hours(5)};

FrameBudget budget_until(Nanoseconds deadline) {
  FrameBudget budget;
  budget.limited = true;
  budget.deadline = kStart + deadline;
  budget.unit_cost_ns = 100;
  budget.job_overhead_ns = 50;
  return budget;
}

std::uint64_t drawn(std::uint64_t& noise, std::uint64_t most) {
  noise = noise * 6364136223846793005ULL + 1442695040888963407ULL;
  return (noise >> 33U) % most;
}

TEST(RefineUntil, ServesTheHighestPriorityFirstAndEachToItsEndWhileThereIsTime) {
  RefineQueue queue;
  queue.begin_frame(3, 3);
  EXPECT_TRUE(queue.add(0, 10, 4));
  EXPECT_TRUE(queue.add(1, 200, 4));
  EXPECT_TRUE(queue.add(2, 100, 4));
  std::vector<std::uint32_t> order;
  std::array<int, 3> level{};
  const RefineCounts counts = refine_until(
      queue, FrameBudget{}, 512, [] { return kStart; },
      [&](std::uint32_t item, std::uint64_t units) {
        order.push_back(item);
        const bool more = ++level[item] < 2;
        return JobOutcome{more ? Kind::Completed : Kind::Done, units, 8, 50, more ? 0 : -1};
      });
  EXPECT_EQ(order, (std::vector<std::uint32_t>{1, 2, 2, 1, 0, 0}));
  EXPECT_EQ(counts.jobs, 6U);
  EXPECT_EQ(counts.units, 3U * (4 + 8));
  EXPECT_FALSE(counts.cut);
  EXPECT_EQ(queue.open(), 0U);
  EXPECT_EQ(queue.tail_items(), 0U);
}

TEST(RefineUntil, RefusesAnItemThatIsThereAlreadyOrThatThereIsNot) {
  RefineQueue queue;
  queue.begin_frame(2, 0);
  EXPECT_FALSE(queue.add(2, 0, 1));
  EXPECT_TRUE(queue.add(1, 0, 1));
  EXPECT_FALSE(queue.add(1, 9, 1)) << "in the queue";
  EXPECT_EQ(queue.take(), 1U);
  EXPECT_FALSE(queue.add(1, 9, 1)) << "in hand";
  queue.close(1);
  EXPECT_TRUE(queue.add(1, 9, 1));
  EXPECT_EQ(queue.open(), 1U);
  queue.begin_frame(2, 0);
  EXPECT_EQ(queue.open(), 0U);
  EXPECT_EQ(queue.take(), RefineQueue::kNone);
}

TEST(RefineUntil, ASmallerJobStillFitsWhereALargeOneDoesNot) {
  RefineQueue queue;
  queue.begin_frame(3, 0);
  queue.add(0, 200, 400);  // 40 us
  queue.add(1, 100, 20);   // 2 us
  queue.add(2, 50, 20);
  std::vector<std::uint32_t> order;
  TimePoint clock = kStart;
  const RefineCounts counts = refine_until(
      queue, budget_until(microseconds(10)), 512, [&] { return clock; },
      [&](std::uint32_t item, std::uint64_t units) {
        order.push_back(item);
        clock += Nanoseconds(50 + 100 * static_cast<std::int64_t>(units));
        return JobOutcome{Kind::Done, units};
      });
  EXPECT_EQ(order, (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(counts.left, 1U);
  EXPECT_EQ(counts.busy, Nanoseconds(4100));
  EXPECT_EQ(counts.longest, Nanoseconds(2050));
  EXPECT_EQ(counts.overrun, Nanoseconds(0));
}

TEST(RefineUntil, AJobIsDoneInBoundedPartsAndAbandonedAtTheCut) {
  const auto run = [](Nanoseconds deadline) {
    RefineQueue queue;
    queue.begin_frame(1, 1);
    queue.add(0, 0, 1000);
    TimePoint clock = kStart;
    std::uint64_t done = 0;
    const RefineCounts counts = refine_until(
        queue, budget_until(deadline), 300, [&] { return clock; },
        [&](std::uint32_t, std::uint64_t units) {
          EXPECT_LE(units, 300U);
          clock += Nanoseconds(50 + 100 * static_cast<std::int64_t>(units));
          done += units;
          if (done < 1000) return JobOutcome{Kind::Part, units, 1000 - done};
          return JobOutcome{Kind::Done, units};
        });
    EXPECT_EQ(queue.open(), 0U);
    return counts;
  };
  const RefineCounts whole = run(microseconds(101));
  EXPECT_EQ(whole.jobs, 1U);
  EXPECT_EQ(whole.parts, 4U);
  EXPECT_EQ(whole.abandoned, 0U);
  const RefineCounts cut = run(microseconds(70));
  EXPECT_EQ(cut.jobs, 0U);
  EXPECT_EQ(cut.parts, 2U);
  EXPECT_EQ(cut.abandoned, 1U);
}

TEST(RefineUntil, WhatIsFoundApartGivesItsTailTimeBack) {
  // Each item reserves 10 us for the tail until it is separated: only then is there time for the others.
  FrameBudget budget = budget_until(microseconds(102));
  budget.tail_per_contact_ns = 10'000;
  const auto refined = [&](std::int64_t change) {
    RefineQueue queue;
    queue.begin_frame(10, 10);
    for (std::uint32_t item = 0; item < 10; ++item) queue.add(item, 0, 10);
    TimePoint clock = kStart;
    return refine_until(
               queue, budget, 512, [&] { return clock; },
               [&](std::uint32_t, std::uint64_t units) {
                 clock += Nanoseconds(1050);
                 return JobOutcome{Kind::Done, units, 0, 0, change};
               })
        .jobs;
  };
  EXPECT_EQ(refined(0), 1U);
  EXPECT_EQ(refined(-1), 10U);
}

TEST(RefineUntil, LeavesWhenIdleUnlessTheHostLooksAgain) {
  RefineQueue queue;
  queue.begin_frame(2, 0);
  queue.add(0, 0, 1);
  ASSERT_EQ(queue.take(), 0U);  // another thread holds it
  int looked = 0;
  const auto done = [&](std::uint32_t, std::uint64_t units) { return JobOutcome{Kind::Done, units}; };
  const auto clock = [] { return kStart; };
  EXPECT_EQ(refine_until(queue, FrameBudget{}, 8, clock, done).jobs, 0U);
  const RefineCounts counts = refine_until(queue, FrameBudget{}, 8, clock, done, [&] {
    if (++looked == 3) queue.give_back(0, 0, 1);
    return true;
  });
  EXPECT_EQ(counts.jobs, 1U);
  EXPECT_EQ(looked, 3);
}

TEST(RefineUntil, AJobThatIsDroppedIsCountedAndNotServedAgain) {
  RefineQueue queue;
  queue.begin_frame(1, 1);
  queue.add(0, 7, 3);
  const RefineCounts counts = refine_until(
      queue, FrameBudget{}, 8, [] { return kStart; },
      [](std::uint32_t, std::uint64_t) { return JobOutcome{Kind::Discarded}; });
  EXPECT_EQ(counts.discarded, 1U);
  EXPECT_EQ(counts.jobs, 0U);
  EXPECT_EQ(queue.open(), 0U);
}

// A frame of items with levels of unknown sizes, whose jobs take more or less than forecast.
struct InventedFrame {
  explicit InventedFrame(std::uint64_t seed) : noise(seed) {
    const auto items = static_cast<std::uint32_t>(1 + drawn(noise, 200));
    queue.begin_frame(items, static_cast<std::int64_t>(items));
    level.assign(items, 0);
    left.assign(items, 0);
    for (std::uint32_t item = 0; item < items; ++item) {
      left[item] = drawn(noise, 800);
      queue.add(item, static_cast<std::uint32_t>(drawn(noise, kBands)), left[item]);
    }
    budget = budget_until(microseconds(static_cast<std::int64_t>(drawn(noise, 3000))));
    budget.tail_fixed = microseconds(static_cast<std::int64_t>(drawn(noise, 300)));
    budget.tail_per_contact_ns = static_cast<double>(drawn(noise, 3000));
    budget.margin = 1.0 + 0.1 * static_cast<double>(drawn(noise, 10));
    quantum = 1 + drawn(noise, 600);
  }

  JobOutcome job(std::uint32_t item, std::uint64_t units) {
    // Checked at the moment at which it begins.
    if (clock + budget.job_cost(units) > budget.cut(queue.tail_items())) ++too_late;
    const double speed = 0.5 + static_cast<double>(drawn(noise, 100)) * 0.01;
    clock += Nanoseconds(static_cast<std::int64_t>(speed * static_cast<double>(budget.job_cost(units).count())));
    done += units;
    left[item] -= units;
    if (left[item] > 0) return {Kind::Part, units, left[item]};
    ++completed;
    if (++level[item] == 3 || drawn(noise, 4) == 0) return {Kind::Done, units, 0, 0, drawn(noise, 2) == 0 ? -1 : 0};
    left[item] = drawn(noise, 800);
    return {Kind::Completed, units, left[item], static_cast<std::uint32_t>(drawn(noise, kBands))};
  }

  std::uint64_t noise;
  RefineQueue queue;
  FrameBudget budget;
  TimePoint clock = kStart;
  std::uint64_t quantum = 1, completed = 0, done = 0;
  int too_late = 0;
  std::vector<int> level;
  std::vector<std::uint64_t> left;
};

RC_GTEST_PROP(RefineUntil, NoJobBeginsWhoseForecastDoesNotFitAndNoneThatFitsIsLeft, ()) {
  InventedFrame frame(*rc::gen::arbitrary<std::uint64_t>());
  const std::uint32_t items = frame.queue.open();
  const RefineCounts counts = refine_until(
      frame.queue, frame.budget, frame.quantum, [&] { return frame.clock; },
      [&](std::uint32_t item, std::uint64_t units) { return frame.job(item, units); });
  RC_ASSERT(frame.too_late == 0);
  RC_ASSERT(counts.jobs == frame.completed);
  RC_ASSERT(counts.units == frame.done);
  RC_ASSERT(counts.ended == frame.clock);
  RC_ASSERT(counts.abandoned + counts.left + frame.queue.open() <= items);
  RC_ASSERT(counts.cut == (frame.queue.open() > 0));
  // Items that are still in the queue would not end in time, for any division into parts.
  for (std::uint32_t item = frame.queue.take(); item != RefineQueue::kNone; item = frame.queue.take()) {
    const std::uint64_t units = std::min(frame.queue.units_of(item), frame.quantum);
    RC_ASSERT(!frame.budget.admits(frame.clock, units, frame.queue.tail_items()));
  }
}

// Items that pass from thread to thread over many levels. Their states are plain numbers, ordered by the queue alone,
// so an item that two threads hold at once is also a race for the thread sanitizer. Each thread has its own clock.
TEST(RefineUntil, LosesNoItemAndServesNoneTwiceOnManyThreads) {
  constexpr std::uint32_t kItems = 2000;
  constexpr std::uint32_t kLevels = 6;
  for (const int threads : {1, 2, 8}) {
    RefineQueue queue;
    for (int frame = 0; frame < 5; ++frame) {
      queue.begin_frame(kItems, kItems);
      std::vector<std::uint32_t> level(kItems, 0);
      for (std::uint32_t item = 0; item < kItems; ++item) ASSERT_TRUE(queue.add(item, item % kBands, 10 + item % 7));
      std::vector<RefineCounts> counts(static_cast<std::size_t>(threads));
      const auto work = [&](RefineCounts& mine) {
        TimePoint clock = kStart;
        mine = refine_until(
            queue, budget_until(std::chrono::seconds(5)), 512, [&] { return clock; },
            [&](std::uint32_t item, std::uint64_t units) {
              clock += microseconds(1);
              if (++level[item] == kLevels) return JobOutcome{Kind::Done, units, 0, 0, -1};
              return JobOutcome{Kind::Completed, units, 5 + item % 11, (item * 31 + level[item] * 17) % kBands};
            },
            [] {
              std::this_thread::yield();
              return true;
            });
      };
      {
        std::vector<std::jthread> workers;
        for (RefineCounts& mine : counts) workers.emplace_back(work, std::ref(mine));
      }
      RefineCounts all;
      for (const RefineCounts& mine : counts) all.add(mine);
      EXPECT_TRUE(std::ranges::all_of(level, [](std::uint32_t done) { return done == kLevels; })) << threads;
      EXPECT_EQ(all.jobs, std::uint64_t{kItems} * kLevels);
      EXPECT_EQ(queue.open(), 0U);
      EXPECT_EQ(queue.tail_items(), 0U);
    }
  }
}

TEST(RefineUntil, UnderADeadlineEveryItemIsAccountedForOnManyThreads) {
  constexpr std::uint32_t kItems = 3000;
  RefineQueue queue;
  for (int frame = 0; frame < 10; ++frame) {
    queue.begin_frame(kItems, kItems);
    std::vector<std::uint8_t> ended(kItems, 0);
    std::vector<std::uint32_t> jobs(kItems, 0);
    for (std::uint32_t item = 0; item < kItems; ++item) queue.add(item, item % kBands, 1 + item % 40);
    std::array<RefineCounts, 4> counts;
    std::array<int, 4> too_late{};
    // The tail does not vary, so a job sees at its beginning the values by which it was admitted.
    const FrameBudget budget = budget_until(microseconds(700 + 100 * frame));
    const auto work = [&](std::size_t thread) {
      TimePoint clock = kStart;
      counts[thread] = refine_until(
          queue, budget, 16, [&] { return clock; },
          [&](std::uint32_t item, std::uint64_t units) {
            if (clock + budget.job_cost(units) > budget.cut(0)) ++too_late[thread];
            clock += budget.job_cost(units);
            ++jobs[item];
            if (jobs[item] % 3 != 0) return JobOutcome{Kind::Part, units, units};
            if (jobs[item] < 9) return JobOutcome{Kind::Completed, units, 1 + item % 20, item % kBands};
            ended[item] = 1;
            return JobOutcome{Kind::Done, units};
          });
    };
    {
      std::vector<std::jthread> workers;
      for (std::size_t thread = 0; thread < counts.size(); ++thread) workers.emplace_back(work, thread);
    }
    RefineCounts all;
    for (const RefineCounts& mine : counts) all.add(mine);
    EXPECT_EQ(std::accumulate(too_late.begin(), too_late.end(), 0), 0);
    EXPECT_EQ(all.parts, std::accumulate(jobs.begin(), jobs.end(), std::uint64_t{0}));
    EXPECT_LE(all.ended, budget.cut(0));
    const auto refined = static_cast<std::uint64_t>(std::ranges::count(ended, std::uint8_t{1}));
    EXPECT_EQ(refined + all.left + all.abandoned + queue.open(), kItems);
    EXPECT_GT(refined, 0U);
    EXPECT_LT(refined, kItems) << "the deadline cuts";
  }
}

TEST(RefineUntil, TheCostOfAUnitIsFollowed) {
  UnitCost cost(60);
  RefineCounts counts;
  counts.units = 1000;
  counts.parts = 10;
  counts.busy = Nanoseconds(1000 * 25 + 10 * 50);
  for (int frame = 0; frame < 60; ++frame) cost.learn(counts, 50);
  EXPECT_NEAR(cost.ns(), 25, 0.01);
  counts.units = UnitCost::kLeastUnits - 1;
  counts.busy = std::chrono::hours(1);
  cost.learn(counts, 50);
  EXPECT_NEAR(cost.ns(), 25, 0.01) << "too little to learn from";
  counts.units = 1000;
  counts.busy = Nanoseconds(0);
  for (int frame = 0; frame < 500; ++frame) cost.learn(counts, 50);
  EXPECT_GT(cost.ns(), 0) << "never nothing";
  EXPECT_EQ(UnitCost(-3).ns(), 60);
}

// A host's frames from start to end with invented times: counted features, a tail that varies, and a margin that
// learns.
TEST(RefineUntil, WithAForecastOfTheHostsFeaturesMissesAreAboutAsRareAsAsked) {
  constexpr std::array<ForecastFeature, 2> kFeatures{{{"constant", 50}, {"contacts_k", 500}}};
  constexpr double kAlpha = 0.05;
  LinearForecast tail(kFeatures);
  TrackedQuantile margin(kAlpha, 0.05);
  UnitCost unit(60);
  std::uint64_t noise = 9;
  RefineQueue queue;
  int late = 0;
  std::uint64_t jobs = 0;
  constexpr int kFrames = 4000;
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto items = static_cast<std::uint32_t>(100 + drawn(noise, 100));
    queue.begin_frame(items, items);
    for (std::uint32_t item = 0; item < items; ++item) queue.add(item, item % kBands, 20);
    const FrameBudget budget = make_frame_budget(kStart + microseconds(600), Nanoseconds(0), tail, margin,
                                                 std::array{1.0, 0.0}, 1, 1e-3, unit.ns());
    TimePoint clock = kStart;
    const RefineCounts counts = refine_until(
        queue, budget, 512, [&] { return clock; },
        [&](std::uint32_t, std::uint64_t units) {
          clock += Nanoseconds(static_cast<std::int64_t>(150 + units * (70 + drawn(noise, 20))));
          return JobOutcome{Kind::Done, units, 0, 0, drawn(noise, 3) == 0 ? 0 : -1};
        });
    unit.learn(counts, budget.job_overhead_ns);
    jobs += counts.jobs;
    const std::uint64_t contacts = queue.tail_items();
    const Nanoseconds actual(static_cast<std::int64_t>((80'000 + 900 * contacts) * (700 + drawn(noise, 600)) / 1000));
    if (frame >= 500 && clock + actual > budget.deadline) ++late;
    margin.observe(actual, budget.tail_forecast(contacts));
    tail.learn(std::array{1.0, 1e-3 * static_cast<double>(contacts)}, actual);
  }
  EXPECT_LT(late, 1.3 * kAlpha * (kFrames - 500));
  EXPECT_GT(jobs, std::uint64_t{50} * kFrames) << "and it refines";
}

}  // namespace
}  // namespace poise::scheduler
