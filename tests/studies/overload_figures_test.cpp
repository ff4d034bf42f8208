// SPDX-License-Identifier: MIT
#include "studies/overload_figures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <vector>

// All frames are invented.
namespace poise::simulation {
namespace {

using std::chrono::milliseconds;

RunFrame frame_at(Level level, std::uint32_t contacts = 10) {
  RunFrame frame;
  frame.report.level_histogram[level] = contacts;
  return frame;
}

std::vector<RunFrame> frames_at(Level level, std::size_t count) {
  return std::vector<RunFrame>(count, frame_at(level));
}

std::vector<RunFrame> joined(std::vector<RunFrame> first, const std::vector<RunFrame>& then) {
  first.insert(first.end(), then.begin(), then.end());
  return first;
}

std::optional<std::uint64_t> recovery_frames(const std::vector<RunFrame>& frames,
                                             const std::vector<RunFrame>& unlimited) {
  return recovery(frames, unlimited).frames;
}

TEST(OverloadSteps, GoUpByHalfOctavesAndComeBackOverTheSame) {
  const std::vector<OverloadStep> steps = overload_steps(0.5, 4);
  ASSERT_EQ(steps.size(), 14U);
  EXPECT_EQ(steps.front().demand, 0.5);
  EXPECT_NEAR(steps[1].demand, 0.70711, 1e-5);
  EXPECT_EQ(steps[2].demand, 1);
  EXPECT_EQ(steps[6].demand, 4);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_TRUE(steps[i].up);
    EXPECT_FALSE(steps[7 + i].up);
    EXPECT_EQ(steps[i].demand, steps[13 - i].demand) << "the same to the bit, so that they are compared";
  }
  const std::vector<OverloadStep> odd = overload_steps(0.5, 1.2);
  ASSERT_EQ(odd.size(), 8U);
  EXPECT_EQ(odd[3].demand, 1.2) << "the last interval is shorter";
}

TEST(OverloadRow, TellsTheSecondHalfOfAStepAndTheLateFramesOfAll) {
  std::vector<RunFrame> frames = joined(frames_at(0, 5), frames_at(2, 5));
  const std::vector<RunFrame> unlimited(10, [] {
    RunFrame frame = frame_at(2);
    frame.report.potential_j = 200;
    return frame;
  }());
  frames[0].report.cause = MissCause::Infeasible;
  frames[1].report.cause = MissCause::Overrun;
  frames[2].report.cause = MissCause::Forecast;
  frames[9].report.cause = MissCause::Machine;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    FrameReport& report = frames[i].report;
    report.bodies = 7 + i;
    report.coarse_pairs = 100;
    report.pairs_left = i < 5 ? 100 : 25;
    report.times.total = milliseconds(i < 5 ? 90 : i);
    report.potential_j = i < 5 ? 0 : 150;
    report.kinetic_j = i < 5 ? 1000 : static_cast<double>(i);
    report.degraded.bodies_held = i == 9 ? 10 : 0;
  }
  frames[3].report.reference.emplace().e_seen_mps = 8;
  frames[6].report.reference.emplace().e_seen_mps = 1;
  frames[8].report.reference.emplace().e_seen_mps = 2;
  const OverloadRow row = overload_row({false, 2}, frames, unlimited);
  EXPECT_FALSE(row.up);
  EXPECT_EQ(row.demand, 2);
  EXPECT_EQ(row.bodies, 16U);
  EXPECT_EQ(row.level_mean, 2);
  EXPECT_EQ(row.left_share, 0.25);
  EXPECT_EQ(row.frames, 10U);
  EXPECT_EQ(row.infeasible, 1U);
  EXPECT_EQ(row.machine, 1U);
  EXPECT_EQ(row.own, 2U);
  EXPECT_EQ(row.p50_ms, 7);
  EXPECT_EQ(row.p99_ms, 9);
  EXPECT_EQ(row.held_mean, 2);
  EXPECT_EQ(row.kinetic_j, 7);
  EXPECT_EQ(row.potential_relative, 0.75);
  EXPECT_FALSE(row.e_seen_mps) << "of references that did not converge";
  for (RunFrame& frame : frames) {
    if (frame.report.reference) frame.report.reference->converged = true;
  }
  EXPECT_EQ(overload_row({false, 2}, frames, unlimited).e_seen_mps, 1.5);
}

TEST(OverloadRow, IsEmptyWhereNothingTouchesAndNothingHasAHeight) {
  const std::vector<RunFrame> frames(4);
  const OverloadRow row = overload_row({true, 1}, frames, frames);
  EXPECT_FALSE(row.level_mean);
  EXPECT_FALSE(row.potential_relative);
  EXPECT_FALSE(row.e_seen_mps);
  EXPECT_EQ(row.left_share, 0);
}

OverloadLoop loop_of(const std::vector<OverloadLoop>& loops, const std::string& name) {
  const auto at = std::ranges::find(loops, name, &OverloadLoop::name);
  EXPECT_NE(at, loops.end()) << name;
  return at == loops.end() ? OverloadLoop{} : *at;
}

TEST(OverloadLoops, AreTheLargestDifferenceOfBackAndUpAtTheSameDemand) {
  std::vector<OverloadRow> rows(6);
  const double demands[] = {0.5, 1, 4, 4, 1, 0.5};
  const double levels[] = {2, 2, 1, 0.9, 0.5, 2};
  const double p50_ms[] = {3, 5, 5, 5, 4, 7};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].up = i < 3;
    rows[i].demand = demands[i];
    rows[i].level_mean = levels[i];
    rows[i].p50_ms = p50_ms[i];
    rows[i].frames = 10;
  }
  rows[4].infeasible = 2;
  rows[4].own = 1;
  rows[0].e_seen_mps = 3;  // and not on the way back
  const std::vector<OverloadLoop> loops = overload_loops(rows);
  EXPECT_EQ(loop_of(loops, "level_mean").difference, -1.5);
  EXPECT_EQ(loop_of(loops, "level_mean").demand, 1);
  EXPECT_EQ(loop_of(loops, "p50_ms").difference, 4);
  EXPECT_EQ(loop_of(loops, "p50_ms").demand, 0.5);
  EXPECT_EQ(loop_of(loops, "late_share").difference, 0.3);
  EXPECT_EQ(loop_of(loops, "left_share").difference, 0) << "no loop";
  EXPECT_FALSE(loop_of(loops, "e_seen_mps").difference);
}

TEST(Recovery, CountsFramesUntilTenInARowHaveTheLevelsOfTheDriveWithoutALimit) {
  const std::vector<RunFrame> full = frames_at(2, 60);
  EXPECT_EQ(recovery_frames(frames_at(2, 60), full), 0U);
  EXPECT_EQ(recovery_frames(joined(frames_at(1, 25), frames_at(2, 35)), full), 25U);
  EXPECT_EQ(recovery_frames(frames_at(1, 60), full), std::nullopt);
  EXPECT_EQ(recovery_frames(joined(frames_at(1, 51), frames_at(2, 9)), full), std::nullopt) << "nine say too little";
}

TEST(Recovery, AllowsAFiftiethOfALevelAndNoMore) {
  const std::vector<RunFrame> full(10, frame_at(2, 1000));
  std::vector<RunFrame> nearly = full;
  for (RunFrame& frame : nearly) {
    frame.report.level_histogram[2] = 981;
    frame.report.level_histogram[1] = 19;
  }
  EXPECT_EQ(recovery_frames(nearly, full), 0U);
  for (RunFrame& frame : nearly) {
    frame.report.level_histogram[2] = 979;
    frame.report.level_histogram[1] = 21;
  }
  EXPECT_EQ(recovery_frames(nearly, full), std::nullopt);
}

TEST(Recovery, FramesInWhichNothingTouchesAreNotBackAndSayNothingWhereNothingTouchesWithoutALimit) {
  const std::vector<RunFrame> empty(30);
  EXPECT_EQ(recovery_frames(empty, frames_at(2, 30)), std::nullopt);
  EXPECT_TRUE(recovery(empty, frames_at(2, 30)).defined) << "there was something to come back to";
  EXPECT_EQ(recovery_frames(empty, empty), std::nullopt);
  EXPECT_FALSE(recovery(empty, empty).defined);
  EXPECT_FALSE(recovery({}, {}).defined);
  EXPECT_EQ(recovery_frames(frames_at(2, 30), joined(std::vector<RunFrame>(15), frames_at(2, 15))), 6U)
      << "the first ten in which something touches";
}

TEST(Recovery, PolygonsAreALevelMoreThanTheDeepestOfSpheres) {
  const std::vector<RunFrame> polygons = frames_at(kPolygonBin, 30);
  EXPECT_EQ(recovery_frames(polygons, polygons), 0U);
  EXPECT_EQ(recovery_frames(joined(frames_at(3, 12), frames_at(kPolygonBin, 18)), polygons), 12U);
  EXPECT_EQ(recovery_frames(frames_at(3, 30), polygons), std::nullopt) << "by spheres alone they are not back";
  RunFrame mixed = frame_at(3, 1000);
  mixed.report.level_histogram[kPolygonBin] = 1000;
  const std::vector<RunFrame> half(30, mixed);
  // 3.5 in the mean with polygons as level 4: 980 of 2,000 are a hundredth of a level below, 950 two and a half.
  mixed.report.level_histogram = {};
  mixed.report.level_histogram[3] = 1020;
  mixed.report.level_histogram[kPolygonBin] = 980;
  EXPECT_EQ(recovery_frames(std::vector<RunFrame>(30, mixed), half), 0U);
  mixed.report.level_histogram[3] = 1050;
  mixed.report.level_histogram[kPolygonBin] = 950;
  EXPECT_EQ(recovery_frames(std::vector<RunFrame>(30, mixed), half), std::nullopt);
}

}  // namespace
}  // namespace poise::simulation
