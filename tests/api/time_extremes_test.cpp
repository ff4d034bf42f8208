// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "frame/scenes.h"
#include "poise/time_arithmetic.h"

namespace poise {
namespace {

using TimePoint = SteadyClock::time_point;

TEST(SaturatingTime, StopsAtTheEndsOfItsRange) {
  const Nanoseconds one(1);
  EXPECT_EQ(saturating_add(Nanoseconds::max(), one), Nanoseconds::max());
  EXPECT_EQ(saturating_add(Nanoseconds::min(), -one), Nanoseconds::min());
  EXPECT_EQ(saturating_add(Nanoseconds::max(), -one), Nanoseconds::max() - one);
  EXPECT_EQ(saturating_add(TimePoint::max(), one), TimePoint::max());
  EXPECT_EQ(saturating_add(TimePoint::min(), Nanoseconds::min()), TimePoint::min());
  EXPECT_EQ(saturating_subtract(TimePoint::max(), TimePoint::min()), Nanoseconds::max());
  EXPECT_EQ(saturating_subtract(TimePoint::min(), TimePoint::max()), Nanoseconds::min());
  EXPECT_EQ(saturating_subtract(TimePoint(Nanoseconds(5)), TimePoint(Nanoseconds(7))), Nanoseconds(-2));
  EXPECT_EQ(saturating_subtract(TimePoint(Nanoseconds(0)), TimePoint::min()), Nanoseconds::max());
  const TimePoint now(std::chrono::hours(3));
  EXPECT_EQ(within_reach(TimePoint::max(), now), now + kFarthestTime);
  EXPECT_EQ(within_reach(TimePoint::min(), now), now - kFarthestTime);
  EXPECT_EQ(within_reach(now + one, now), now + one);
}

TEST(SaturatingTime, OfABudgetIsNoOverflow) {
  EXPECT_EQ(Budget::within(Nanoseconds::max()).deadline, TimePoint::max());
  EXPECT_LT(Budget::within(Nanoseconds::min()).deadline, TimePoint(Nanoseconds(0)));
}

FrameReport step_with(World& world, const Budget& budget, const HostWork& host) {
  StepInput input;
  input.budget = budget;
  input.host_work = host;
  return world.step(input);
}

TEST(ExtremeTimes, OfDeadlinesAndHostWorkAreStepped) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.threads = 2;
  settings.executor = ExecutorKind::Threads;
  Stage stage(settings);
  stage.jacks(40, 8);
  const std::array budgets = {Budget::within(Nanoseconds::max()),
                              Budget::until(TimePoint::max()),
                              Budget::until(TimePoint::min()),
                              Budget::within(Nanoseconds::min()),
                              Budget::until({}),
                              Budget::within(std::chrono::milliseconds(5))};
  const std::array hosts = {HostWork{}, HostWork{false, Nanoseconds::max()}, HostWork{true, {}}};
  for (int round = 0; round < 3; ++round) {
    for (const Budget& budget : budgets) {
      for (const HostWork& host : hosts) {
        const bool long_past = budget.deadline <= TimePoint{};
        const bool far = budget.deadline == TimePoint::max();
        const FrameReport report = step_with(stage.world, budget, host);
        ASSERT_EQ(report.status, StepStatus::Done);
        EXPECT_GE(report.lateness.count(), 0);
        EXPECT_LE(report.lateness, 4 * kFarthestTime);
        EXPECT_LE(report.host_reserved, 8 * kFarthestTime);
        if (long_past) {
          EXPECT_GT(report.lateness.count(), 0);
          EXPECT_LT(report.budget.count(), 0);
        }
        if (far && host.expected.count() == 0 && !host.learn) {
          EXPECT_EQ(report.lateness.count(), 0);
          EXPECT_EQ(report.pairs_left, 0U);
        }
        stage.world.report_host_work(round == 0 ? Nanoseconds::max() : Nanoseconds::min());
      }
    }
  }
  for (const BodyId body : stage.bodies) ASSERT_TRUE(stage.world.state(body).value().position_m.allFinite());
}

}  // namespace
}  // namespace poise
