// SPDX-License-Identifier: MIT
#include "poise/scheduler/frame_budget.h"

#include <gtest/gtest.h>

#include <array>

namespace poise::scheduler {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

// All times are invented.
const TimePoint kStart{std::chrono::hours(5)};

FrameBudget plain_budget() {
  FrameBudget budget;
  budget.limited = true;
  budget.deadline = kStart + milliseconds(10);
  budget.tail_fixed = milliseconds(2);
  budget.tail_per_contact_ns = 1000;
  budget.unit_cost_ns = 50;
  budget.job_overhead_ns = 0;
  return budget;
}

TEST(FrameBudget, TheCutIsTheDeadlineLessHostWorkLessReserve) {
  FrameBudget budget = plain_budget();
  budget.host_work = milliseconds(3);
  EXPECT_EQ(budget.cut(0), kStart + milliseconds(5));
  EXPECT_EQ(budget.cut(1000), kStart + milliseconds(4));
}

TEST(FrameBudget, TheReserveTakesNothingOfWhatRefinementHasForSure) {
  FrameBudget budget = plain_budget();
  budget.earliest_cut = kStart + milliseconds(8) - microseconds(500);
  EXPECT_EQ(budget.cut(0), kStart + milliseconds(8));
  EXPECT_EQ(budget.cut(1000), kStart + milliseconds(8) - microseconds(500));
}

TEST(FrameBudget, APairFoundApartGivesItsResponseTimeBack) {
  const FrameBudget budget = plain_budget();
  EXPECT_EQ(budget.cut(99) - budget.cut(100), microseconds(1));
}

TEST(FrameBudget, AJobIsAdmittedOnlyIfItsForecastEndsBeforeTheCut) {
  const FrameBudget budget = plain_budget();  // the cut is at 8 ms
  const std::uint64_t units = 100;            // 5 us
  EXPECT_TRUE(budget.admits(kStart + milliseconds(8) - microseconds(5), units, 0));
  EXPECT_FALSE(budget.admits(kStart + milliseconds(8) - microseconds(5) + Nanoseconds(1), units, 0));
}

TEST(FrameBudget, WithoutADeadlineEveryJobIsAdmitted) {
  EXPECT_TRUE(FrameBudget{}.admits(TimePoint::max() - std::chrono::hours(1), 1U << 20U, 1U << 20U));
}

TEST(FrameBudget, TheReserveIsTheForecastTimesTheMargin) {
  TailForecast tail;
  const TailWork work{1000, 0, 5000, 0};
  for (int frame = 0; frame < 500; ++frame) {
    TailWork varied = work;
    varied.contacts = static_cast<std::uint64_t>(100 * (frame % 40));
    tail.learn(varied, microseconds(500) + Nanoseconds(400 * varied.contacts));
  }
  const TrackedQuantile margin(0.01, 0.05, 0.7);
  const FrameBudget budget = make_frame_budget(kStart + milliseconds(16), milliseconds(1), tail, margin, work, 33);
  TailWork full = work;
  full.contacts = 2500;
  const double expected = static_cast<double>(tail.forecast(full).count()) * margin.factor();
  EXPECT_NEAR(static_cast<double>(budget.reserve(2500).count()), expected, 1e-3 * expected);
  EXPECT_EQ(budget.host_work, milliseconds(1));
  EXPECT_DOUBLE_EQ(budget.unit_cost_ns, 33);
}

TEST(FrameBudget, TheReserveFollowsTheForecastWhateverTheFitExtrapolates) {
  // Tails observed only at many contacts, which grow faster there than a line through the origin.
  TailForecast tail;
  for (int frame = 0; frame < 400; ++frame) {
    const TailWork work{2000, 9000 + static_cast<std::uint64_t>(53 * frame) % 2000, 18000, 0};
    tail.learn(work, Nanoseconds(500 * work.contacts) - milliseconds(3));
  }
  const TailWork work{2000, 0, 18000, 0};
  const FrameBudget budget =
      make_frame_budget(kStart, Nanoseconds(0), tail, TrackedQuantile(0.01, 0.05, 0.0), work, 30);
  for (const std::uint64_t contacts : {0ULL, 100ULL, 1000ULL, 10'000ULL, 50'000ULL}) {
    TailWork asked = work;
    asked.contacts = contacts;
    const double expected = static_cast<double>(tail.forecast(asked).count());
    EXPECT_NEAR(static_cast<double>(budget.reserve(contacts).count()), expected, 1e-3 * expected + 1000)
        << "1 us at least";
    EXPECT_EQ(budget.tail_forecast(contacts), budget.reserve(contacts));
  }
  // Near the observed values it is accurate.
  EXPECT_NEAR(static_cast<double>(budget.reserve(10'000).count()), 2e6, 0.3e6);
}

TEST(FrameBudget, ReserveNeverFallsBelowTheTrackedQuantile) {
  // Costs of the tail that vary by half: after learning, the reserve is exceeded about as rarely as requested.
  TailForecast tail;
  TrackedQuantile margin(0.05, 0.02, 0.0);
  int exceeded = 0;
  std::uint32_t noise = 1;
  constexpr int kFrames = 5000;
  for (int frame = 0; frame < kFrames; ++frame) {
    noise = noise * 1664525U + 1013904223U;
    const TailWork work{1000, 500 + noise % 1000, 3000, 0};
    const double swing = 1.0 + 0.5 * static_cast<double>(noise >> 16U) / 65536.0;
    const Nanoseconds actual(static_cast<std::int64_t>((2e5 + 300.0 * static_cast<double>(work.contacts)) * swing));
    const FrameBudget budget = make_frame_budget(kStart, Nanoseconds(0), tail, margin, work, 30);
    if (frame >= 1000 && actual > budget.reserve(work.contacts)) ++exceeded;
    margin.observe(actual, budget.tail_forecast(work.contacts));
    tail.learn(work, actual);
  }
  EXPECT_LT(exceeded, 0.07 * (kFrames - 1000));
  EXPECT_GT(exceeded, 0.03 * (kFrames - 1000));
}

TEST(FrameBudget, KeepsNoMarginForWhatMayBeLeftOut) {
  FrameBudget budget;
  budget.limited = true;
  budget.deadline = kStart + milliseconds(16);
  budget.tail_fixed = milliseconds(2);
  budget.tail_per_contact_ns = 1000;
  budget.margin = 1.5;
  EXPECT_EQ(budget.reserve(1000), microseconds(4500));
  budget.tail_optional = milliseconds(1);
  EXPECT_EQ(budget.tail_forecast(1000), milliseconds(3)) << "what must be done";
  EXPECT_EQ(budget.reserve(1000), microseconds(4500)) << "where that takes no longer, all of it has time";
  budget.tail_optional = milliseconds(2);
  EXPECT_EQ(budget.reserve(1000), milliseconds(5)) << "all that is expected";
  EXPECT_EQ(budget.cut(1000), kStart + milliseconds(11));
}

TEST(FrameBudget, IsMadeOfAForecastOfTheHostsOwnFeatures) {
  constexpr std::array<ForecastFeature, 3> kFeatures{{{"constant", 100}, {"joints", 2}, {"contacts_k", 400}}};
  const LinearForecast tail(kFeatures);
  const TrackedQuantile margin(0.01, 0.05, 0.0);
  const std::array values{1.0, 50.0, 12345.0};
  const FrameBudget budget =
      make_frame_budget(kStart + milliseconds(8), milliseconds(1), tail, margin, values, 2, 1e-3, 70);
  EXPECT_TRUE(budget.limited);
  EXPECT_EQ(budget.tail_forecast(0), microseconds(200)) << "what refinement changes is counted by the items";
  EXPECT_EQ(budget.tail_forecast(500), microseconds(400));
  EXPECT_EQ(budget.cut(500), kStart + milliseconds(7) - microseconds(400));
  EXPECT_DOUBLE_EQ(budget.unit_cost_ns, 70);
  const FrameBudget fixed = make_frame_budget(kStart, Nanoseconds(0), tail, margin, values, 9, 1e-3, 70);
  EXPECT_EQ(fixed.tail_forecast(0), fixed.tail_forecast(1000));
  // Invalid values give no time to refinement.
  const FrameBudget senseless =
      make_frame_budget(kStart, Nanoseconds(0), tail, margin, std::array{1.0, -5.0, 0.0}, 2, 1e-3, 70);
  EXPECT_FALSE(senseless.admits(kStart - std::chrono::hours(1), 1, 0));
}

TEST(FrameBudget, TimesAtTheirExtremesDoNotOverflow) {
  FrameBudget budget = plain_budget();
  budget.deadline = TimePoint::max();
  EXPECT_TRUE(budget.admits(kStart, 1000, 1000));
  budget.host_work = Nanoseconds::min();
  EXPECT_TRUE(budget.admits(kStart, 1000, 1000));
  EXPECT_FALSE(budget.admits(TimePoint::max(), ~std::uint64_t{0}, 0));
  budget.deadline = TimePoint::min();
  EXPECT_FALSE(budget.admits(kStart, 1, 0));
  budget.host_work = Nanoseconds::max();
  EXPECT_EQ(budget.cut(0), TimePoint::min());
  budget.tail_fixed = Nanoseconds::max();
  budget.tail_per_contact_ns = 1e300;
  budget.margin = 8;
  EXPECT_FALSE(budget.admits(kStart, 1, ~std::uint64_t{0}));
}

}  // namespace
}  // namespace poise::scheduler
