// SPDX-License-Identifier: MIT
// Why a frame was late, from invented times.
#include <gtest/gtest.h>

#include <chrono>

#include "frame/budget/frame_time.h"

namespace poise::simulation {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr SteadyClock::time_point kStart{std::chrono::hours(1)};

// A frame that begins at kStart; its stages take what a test says.
struct InventedFrame {
  InventedFrame() { forget_times(forecasts, 0.01, {}); }

  // A frame with so much time from its start to its deadline, whose thread was on a processor all the time but
  // `off_cpu`.
  void account(Nanoseconds budget, Nanoseconds off_cpu, const parallel::Waits& waits = {}) {
    const StageTimes& t = report.times;
    report.started = kStart;
    report.times.total =
        t.predict + t.broad_phase + t.coarse + t.refine + t.manifolds + t.solve + t.integrate + t.publish;
    StepInput input;
    input.budget = Budget::until(kStart + budget);
    const CallerTime caller{t.total - off_cpu, waits};
    account_time(input, {ContactModel::Fitted, 10, 2, table, levels}, 0, caller, forecasts, report);
  }

  PairTable table;
  CompletedLevels levels;
  Forecasts forecasts;
  FrameReport report;
};

TEST(Lateness, OfAFrameThatWasReleasedLateIsNotCalledInfeasible) {
  InventedFrame late;
  late.report.release_delay = microseconds(15500);
  late.report.times.solve = microseconds(70);
  late.account(microseconds(50), Nanoseconds(0));
  EXPECT_EQ(late.report.lateness, microseconds(20));
  EXPECT_GT(late.report.mandatory, late.report.budget);
  EXPECT_EQ(late.report.cause, MissCause::Release);

  InventedFrame punctual;
  punctual.report.times.solve = microseconds(70);
  punctual.account(microseconds(50), Nanoseconds(0));
  EXPECT_EQ(punctual.report.cause, MissCause::Infeasible);
}

TEST(Lateness, OfASliceIsTheMachinesWhereItHeldTheStepsThreadOrAnAwaitedWorkerUp) {
  StepInput input;
  input.budget = Budget::until(kStart + milliseconds(16));
  const auto cause = [&](Nanoseconds cpu, const parallel::Waits& waits) {
    FrameReport report;
    report.started = kStart;
    report.times.total = milliseconds(18);
    account_slice(input, {cpu, waits}, report);
    EXPECT_EQ(report.lateness, milliseconds(2));
    EXPECT_EQ(report.waited, waits.slept);
    return report.cause;
  };
  EXPECT_EQ(cause(milliseconds(18), {}), MissCause::Forecast);
  EXPECT_EQ(cause(milliseconds(16), {}), MissCause::Machine) << "the thread of the step was not run";
  EXPECT_EQ(cause(milliseconds(15), {milliseconds(3), Nanoseconds(0)}), MissCause::Forecast) << "it waited for work";
  EXPECT_EQ(cause(milliseconds(15), {milliseconds(3), milliseconds(2)}), MissCause::Machine) << "nor was the worker";
}

TEST(Lateness, WithTheHostsWorkIsJudgedAgainstTheWholePeriod) {
  InventedFrame late;
  late.report.release_delay = milliseconds(6);
  late.report.times.solve = milliseconds(4);
  late.account(milliseconds(10), Nanoseconds(0));
  EXPECT_EQ(late.report.cause, MissCause::None);
  add_host_work(milliseconds(11), Nanoseconds(0), late.report);
  EXPECT_EQ(late.report.lateness, milliseconds(5));
  EXPECT_EQ(late.report.cause, MissCause::Release);
  add_host_work(milliseconds(14), Nanoseconds(0), late.report);
  EXPECT_EQ(late.report.cause, MissCause::Infeasible) << "18 ms of 16";
}

TEST(Lateness, APieceThatTheMachineHeldUpIsNoOverrun) {
  InventedFrame late;
  late.report.times.refine = milliseconds(10);
  late.report.longest_overrun = microseconds(400);
  late.report.overrun_off_cpu = microseconds(4100);
  // A little less than it was late by: the piece ran on cold caches afterwards.
  late.account(microseconds(5600), microseconds(4200));
  EXPECT_EQ(late.report.lateness, microseconds(4400));
  EXPECT_EQ(late.report.cause, MissCause::Machine);
}

TEST(Lateness, WhatIsMandatoryTakesNoLessThanNothing) {
  InventedFrame held_up;
  held_up.report.times.solve = milliseconds(6);
  held_up.report.times.publish = microseconds(300);
  held_up.forecasts.times.iterated = microseconds(5700);
  // The machine took four milliseconds of the iterations that end in time.
  held_up.account(milliseconds(4), milliseconds(4));
  EXPECT_EQ(held_up.report.tail_optional, microseconds(5700));
  EXPECT_GE(held_up.report.mandatory, Nanoseconds(0));
  EXPECT_GE(held_up.forecasts.times.ns_of_load, 0);
}

TEST(Lateness, OwnWaitsOfAnyStageAreNotTheMachines) {
  parallel::Waits waits;
  waits.add(milliseconds(3), milliseconds(3));
  InventedFrame waited;
  waited.report.times.solve = milliseconds(12);
  waited.account(milliseconds(11), milliseconds(3), waits);
  EXPECT_EQ(waited.report.waited, milliseconds(3));
  EXPECT_EQ(waited.report.off_cpu, Nanoseconds(0));
  EXPECT_EQ(waited.report.mandatory, milliseconds(12));
  EXPECT_EQ(waited.report.cause, MissCause::Infeasible);

  // The other thread was not on a processor either.
  parallel::Waits held_up;
  held_up.add(milliseconds(3), milliseconds(1));
  InventedFrame stolen;
  stolen.report.times.solve = milliseconds(12);
  stolen.account(milliseconds(11), milliseconds(3), held_up);
  EXPECT_EQ(stolen.report.off_cpu, milliseconds(2));
  EXPECT_EQ(stolen.report.mandatory, milliseconds(10));
  EXPECT_EQ(stolen.report.cause, MissCause::Machine);
}

TEST(Waits, HoldUpIsTheTimeInWhichNobodyRan) {
  parallel::Waits waits;
  waits.add(milliseconds(5), milliseconds(2));
  waits.add(milliseconds(1), milliseconds(4));  // two clocks never agree to the last
  EXPECT_EQ(waits.slept, milliseconds(6));
  EXPECT_EQ(waits.held_up, milliseconds(3));
  waits.add(milliseconds(1), milliseconds(-1));
  EXPECT_EQ(waits.held_up, milliseconds(4));
}

}  // namespace
}  // namespace poise::simulation
