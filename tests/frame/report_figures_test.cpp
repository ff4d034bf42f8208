// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <chrono>
#include <vector>

#include "scene/run/run_report.h"

namespace poise::simulation {
namespace {

using std::chrono::milliseconds;

RunFrame tail_frame(Nanoseconds actual, Nanoseconds reserve) {
  RunFrame frame;
  frame.report.tail_forecast = milliseconds(1);
  frame.report.tail_actual = actual;
  frame.report.reserve_at_cut = reserve;
  return frame;
}

TEST(TailFigures, PinballLossWeighsBeingShortAgainstBeingLongAsAlphaSays) {
  const std::vector<RunFrame> frames{tail_frame(milliseconds(5), milliseconds(3)),
                                     tail_frame(milliseconds(1), milliseconds(3))};
  // 2 ms too short at 0.9, 2 ms too long at 0.1.
  EXPECT_NEAR(run_figures(frames, {true, 0.1}).tail.pinball_loss_ms, (0.9 * 2 + 0.1 * 2) / 2, 1e-12);
  EXPECT_NEAR(run_figures(frames, {true, 0.25}).tail.pinball_loss_ms, (0.75 * 2 + 0.25 * 2) / 2, 1e-12);
}

TEST(TailFigures, PinballLossIsLeastWhereTheShareAlphaOfTailsIsLonger) {
  const auto loss = [](int reserve_ms) {
    std::vector<RunFrame> frames;
    for (int tail_ms = 1; tail_ms <= 100; ++tail_ms)
      frames.push_back(tail_frame(milliseconds(tail_ms), milliseconds(reserve_ms)));
    return run_figures(frames, {true, 0.05}).tail.pinball_loss_ms;
  };
  for (const int other : {50, 90, 93, 97, 99}) EXPECT_GT(loss(other), loss(95)) << other;
}

TEST(LowFps, AreOverTheSlowestHundredthAndThousandth) {
  std::vector<RunFrame> frames(2000);
  for (RunFrame& frame : frames) frame.report.times.total = milliseconds(10);
  for (std::size_t i = 0; i < 20; ++i) frames[i].report.times.total = milliseconds(20);
  frames[100].report.times.total = milliseconds(100);
  const RunFigures figures = run_figures(frames, {});
  EXPECT_NEAR(figures.low_1_percent_fps, 1000.0 * 20 / (19 * 20 + 100), 1e-9);
  EXPECT_NEAR(figures.low_0_1_percent_fps, 1000.0 * 2 / 120, 1e-9);
}

TEST(LevelFigures, AreOverTheFramesThatWereLookedAt) {
  std::vector<RunFrame> frames(5);
  EXPECT_EQ(run_figures(frames, {}).levels.frames, 0U);
  LevelsReached first;
  first.bodies[0] = 3;
  first.bodies[2] = 1;
  first.weight[0] = 1;
  first.weight[kPolygonBin] = 2;
  first.left_for_time = 7;
  first.longest_wait = 4;
  LevelsReached second;
  second.bodies[2] = 5;
  second.weight[2] = 1;
  second.left_for_time = 2;
  second.left_for_capacity = 1;
  second.longest_wait = 9;
  frames[1].report.levels = first;
  frames[4].report.levels = second;
  const LevelFigures levels = run_figures(frames, {}).levels;
  EXPECT_EQ(levels.frames, 2U);
  EXPECT_EQ(levels.bodies[0], 3U);
  EXPECT_EQ(levels.bodies[2], 6U);
  EXPECT_DOUBLE_EQ(levels.weight[0], 0.25);
  EXPECT_DOUBLE_EQ(levels.weight[2], 0.25);
  EXPECT_DOUBLE_EQ(levels.weight[kPolygonBin], 0.5);
  EXPECT_DOUBLE_EQ(levels.left_for_time_mean, 4.5);
  EXPECT_DOUBLE_EQ(levels.left_for_capacity_mean, 0.5);
  EXPECT_EQ(levels.longest_wait, 9U);
}

TEST(WorkFigures, SumWhatWasAbandonedAndWhatWasCached) {
  std::vector<RunFrame> frames(3);
  for (RunFrame& frame : frames) {
    frame.report.jobs_discarded = 5;
    frame.report.jobs_abandoned = 2;
    frame.report.cached_separations = 10;
    frame.report.cached_contacts = 20;
  }
  const WorkFigures work = run_figures(frames, {}).work;
  EXPECT_EQ(work.jobs_discarded, 15U);
  EXPECT_EQ(work.jobs_abandoned, 6U);
  EXPECT_EQ(work.cached_separations, 30U);
  EXPECT_EQ(work.cached_contacts, 60U);
}

}  // namespace
}  // namespace poise::simulation
