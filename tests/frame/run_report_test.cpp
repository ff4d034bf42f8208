// SPDX-License-Identifier: MIT
#include "scene/run/run_report.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

namespace poise::simulation {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

RunFrame frame_of(Nanoseconds total, Nanoseconds lateness = Nanoseconds{0}, MissCause cause = MissCause::None) {
  RunFrame frame;
  frame.report.times.total = total;
  frame.report.lateness = lateness;
  frame.report.cause = cause;
  return frame;
}

TEST(Percentiles, AreTheNearestRankOfAHundredValues) {
  std::vector<double> values;
  for (int i = 100; i >= 1; --i) values.push_back(i);
  const Percentiles result = percentiles(values);
  EXPECT_EQ(result.p50, 50);
  EXPECT_EQ(result.p90, 90);
  EXPECT_EQ(result.p95, 95);
  EXPECT_EQ(result.p99, 99);
  EXPECT_EQ(result.p99_9, 100);
  EXPECT_EQ(result.max, 100);
  EXPECT_EQ(result.mean, 50.5);
}

TEST(Percentiles, AreTheOnlyValueOfOneAndZeroOfNone) {
  EXPECT_EQ(percentiles({7}).p50, 7);
  EXPECT_EQ(percentiles({7}).p99_9, 7);
  EXPECT_EQ(percentiles({}).max, 0);
  EXPECT_EQ(percentile({}, 0.5), 0);
  EXPECT_EQ(percentile({3, 1, 2, 4}, 0.5), 2);
}

TEST(IncompleteBeta, AgreesWithItsClosedForms) {
  for (const double x : {0.0, 0.01, 0.3, 0.5, 0.77, 0.999, 1.0}) {
    EXPECT_NEAR(incomplete_beta(1, 1, x), x, 1e-14);
    EXPECT_NEAR(incomplete_beta(3, 1, x), x * x * x, 1e-13);
    EXPECT_NEAR(incomplete_beta(1, 4, x), 1 - std::pow(1 - x, 4), 1e-13);
    EXPECT_NEAR(incomplete_beta(2, 2, x), x * x * (3 - 2 * x), 1e-13);
    EXPECT_NEAR(incomplete_beta(0.5, 0.5, x), 2 / M_PI * std::asin(std::sqrt(x)), 1e-13);
  }
}

// The binomial tail is the definition: P(X >= k) = I_p(k, n - k + 1).
TEST(IncompleteBeta, IsTheTailOfTheBinomialDistribution) {
  const int n = 40;
  const double p = 0.23;
  for (int k = 1; k <= n; ++k) {
    double tail = 0;
    for (int i = k; i <= n; ++i) {
      double choose = 1;
      for (int j = 1; j <= i; ++j) choose = choose * (n - i + j) / j;
      tail += choose * std::pow(p, i) * std::pow(1 - p, n - i);
    }
    EXPECT_NEAR(incomplete_beta(k, n - k + 1, p), tail, 1e-12) << k;
  }
}

TEST(ClopperPearson, HasTheClosedFormsAtNoHitAndAtAllHits) {
  for (const std::uint64_t n : {1U, 10U, 300U, 100000U}) {
    const double edge = std::pow(0.025, 1.0 / static_cast<double>(n));
    EXPECT_EQ(clopper_pearson(0, n, 0.95).low, 0);
    EXPECT_NEAR(clopper_pearson(0, n, 0.95).high, 1 - edge, 1e-9);
    EXPECT_NEAR(clopper_pearson(n, n, 0.95).low, edge, 1e-9);
    EXPECT_EQ(clopper_pearson(n, n, 0.95).high, 1);
  }
  EXPECT_EQ(clopper_pearson(0, 0, 0.95).high, 1);
}

// Published table values (e.g. Newcombe, Statistics in Medicine 17, 1998, Table I, method 5).
TEST(ClopperPearson, AgreesWithPublishedIntervals) {
  const Interval common = clopper_pearson(81, 263, 0.95);
  EXPECT_NEAR(common.low, 0.2527, 5e-5);
  EXPECT_NEAR(common.high, 0.3676, 5e-5);
  const Interval rare = clopper_pearson(1, 29, 0.95);
  EXPECT_NEAR(rare.low, 0.0009, 5e-5);
  EXPECT_NEAR(rare.high, 0.1776, 5e-5);
}

TEST(RunFigures, AReleaseThatWasSkippedBehindAFrameInTimeIsARelease) {
  std::vector<RunFrame> frames(4, frame_of(milliseconds(10)));
  frames[2].releases_skipped = 2;
  const RunFigures figures = run_figures(frames, {true});
  ASSERT_TRUE(figures.misses);
  EXPECT_EQ(figures.misses->count, 2U);
  EXPECT_EQ(figures.misses->release, 2U);
}

TEST(RunFigures, CountsMissesByCauseAndTheCausesSumToTheCount) {
  std::vector<RunFrame> frames(10, frame_of(milliseconds(10)));
  frames[1] = frame_of(milliseconds(20), milliseconds(4), MissCause::Infeasible);
  frames[2] = frame_of(milliseconds(20), milliseconds(6), MissCause::Machine);
  frames[3] = frame_of(milliseconds(20), milliseconds(8), MissCause::Overrun);
  frames[7] = frame_of(milliseconds(20), milliseconds(2), MissCause::Forecast);
  frames[9] = frame_of(milliseconds(10), milliseconds(5), MissCause::Release);
  const RunFigures figures = run_figures(frames, {true});
  ASSERT_TRUE(figures.misses);
  const MissFigures& misses = *figures.misses;
  EXPECT_EQ(misses.count, 5U);
  EXPECT_EQ(misses.rate, 0.5);
  EXPECT_EQ(misses.release + misses.infeasible + misses.machine + misses.overrun + misses.forecast, misses.count);
  EXPECT_EQ(misses.release, 1U);
  EXPECT_EQ(misses.infeasible, 1U);
  EXPECT_EQ(misses.longest_run, 3U);
  EXPECT_EQ(misses.worst_1000, 5U);
  EXPECT_EQ(misses.tardiness_ms.max, 8);
  EXPECT_EQ(misses.tardiness_ms.mean, 5);
  EXPECT_DOUBLE_EQ(misses.share_of_time_late, 25.0 / 140.0);
  EXPECT_EQ(figures.low_1_percent_fps, 50);
}

TEST(RunFigures, CountsAPassedReleaseAsAMissWithTheCauseOfTheFrameThatRan) {
  std::vector<RunFrame> frames(4, frame_of(milliseconds(10)));
  frames[1] = frame_of(milliseconds(50), milliseconds(34), MissCause::Machine);
  frames[1].releases_skipped = 2;
  const RunFigures figures = run_figures(frames, {true});
  EXPECT_EQ(figures.misses->count, 3U);
  EXPECT_EQ(figures.misses->machine, 3U);
  EXPECT_EQ(figures.misses->releases, 6U);
  EXPECT_EQ(figures.misses->rate, 0.5);
  EXPECT_EQ(figures.misses->longest_run, 3U);
}

TEST(RunFigures, KeepsWarmUpFramesApart) {
  std::vector<RunFrame> frames(3, frame_of(milliseconds(10)));
  frames[0] = frame_of(milliseconds(500), milliseconds(480), MissCause::Machine);
  frames[0].warm_up = true;
  const RunFigures figures = run_figures(frames, {true});
  EXPECT_EQ(figures.frames, 2U);
  EXPECT_EQ(figures.warm_up_frames, 1U);
  EXPECT_EQ(figures.warm_up_misses, 1U);
  EXPECT_EQ(figures.misses->count, 0U);
  EXPECT_EQ(figures.frame_ms.max, 10);
}

TEST(RunFigures, DoesNotDefineMissesOnTheWorkClock) {
  const std::vector<RunFrame> frames(3, frame_of(milliseconds(10)));
  EXPECT_FALSE(run_figures(frames, {false}).misses);
}

TEST(RunFigures, MeasuresRefinementAgainstTheTimeThatWasThereForIt) {
  std::vector<RunFrame> frames(3);
  frames[0].report.times.refine = milliseconds(6);
  frames[0].report.refine_available = milliseconds(8);
  frames[0].report.pairs_left = 5;
  frames[1].report.times.refine = milliseconds(1);
  frames[1].report.refine_available = milliseconds(8);
  const RunFigures figures = run_figures(frames, {true});
  EXPECT_DOUBLE_EQ(figures.refinement_used.value(), 0.75);
  EXPECT_DOUBLE_EQ(figures.refinement_used_all.value(), 7.0 / 16.0);
  EXPECT_FALSE(run_figures({}, {true}).refinement_used);
}

TEST(RunFigures, CountsRefinementOfAStepThatTookSeveralFramesWhole) {
  std::vector<RunFrame> frames(4);
  for (RunFrame& frame : frames) {
    frame.report.times.refine = milliseconds(6);
    frame.report.unfinished = true;
  }
  frames[2].report.unfinished = false;
  frames[2].report.refine_available = milliseconds(20);
  frames[2].report.pairs_left = 5;
  const RunFigures figures = run_figures(frames, {true});
  EXPECT_DOUBLE_EQ(figures.refinement_used.value(), 18.0 / 20.0);
  EXPECT_EQ(figures.frames_a_step().value(), 4);
  frames[2].report.unfinished = true;
  EXPECT_FALSE(run_figures(frames, {true}).frames_a_step());
}

TEST(RunFigures, SaysHowOftenTheReserveHeld) {
  std::vector<RunFrame> frames(4);
  for (RunFrame& frame : frames) {
    frame.report.tail_forecast = microseconds(1000);
    frame.report.reserve_at_cut = microseconds(2000);
    frame.report.tail_actual = microseconds(1000);
    frame.report.cut_margin = 2;
  }
  frames[3].report.tail_actual = microseconds(4000);
  const TailFigures tail = run_figures(frames, {true}).tail;
  EXPECT_EQ(tail.frames, 4U);
  EXPECT_EQ(tail.coverage, 0.75);
  EXPECT_DOUBLE_EQ(tail.reserve_over_actual, 8.0 / 7) << "of all frames together";
  EXPECT_DOUBLE_EQ(tail.reserve_used, (3 * 1.0 + 2) / 8);
  EXPECT_EQ(tail.actual_over_forecast.max, 4);
  EXPECT_EQ(tail.margin_last, 2);
}

TEST(RunFigures, IterationsBeyondOneASubstepAreNotWhatTheReserveIsFor) {
  std::vector<RunFrame> frames(3);
  for (RunFrame& frame : frames) {
    frame.report.tail_forecast = microseconds(1000);
    frame.report.reserve_at_cut = microseconds(1500);
    frame.report.tail_actual = microseconds(4000);
    frame.report.tail_optional = microseconds(3000);
  }
  frames[2].report.tail_optional = frames[2].report.tail_actual;  // nothing that is known of what had to be done
  const TailFigures tail = run_figures(frames, {true}).tail;
  EXPECT_EQ(tail.frames, 2U);
  EXPECT_EQ(tail.coverage, 1);
  EXPECT_DOUBLE_EQ(tail.reserve_over_actual, 1.5);
  EXPECT_EQ(tail.actual_over_forecast.max, 1);
  EXPECT_EQ(tail.reserve_used, 1);
}

TEST(RunFigures, AveragesLevelsOverContactPairsAndAddsUpFullCapacities) {
  std::vector<RunFrame> frames(2);
  frames[0].report.level_histogram = {1, 0, 2};
  frames[0].report.contact_pairs = 3;
  frames[1].report.level_histogram = {0, 1, 0};
  frames[1].report.contact_pairs = 1;
  frames[1].report.fronts_full = 7;
  frames[0].report.work_refine = 30;
  const RunFigures figures = run_figures(frames, {true});
  EXPECT_DOUBLE_EQ(figures.level_mean.value(), (0 + 2 + 2 + 1) / 4.0);
  EXPECT_EQ(figures.level_histogram[2], 2U);
  EXPECT_EQ(figures.contacts_mean, 2);
  EXPECT_EQ(figures.capacity.fronts_full, 7U);
  EXPECT_EQ(figures.work.refine, 30U);
  EXPECT_EQ(figures.work.refine_mean, 15);
  EXPECT_FALSE(run_figures({}, {true}).level_mean);
}

TEST(RunFigures, NamesTheLongestPieceOfRefinementWithItsPair) {
  std::vector<RunFrame> frames(5, frame_of(milliseconds(10)));
  EXPECT_FALSE(run_figures(frames, {true}).longest_job) << "none has taken any time";
  frames[1].report.longest_job = std::chrono::microseconds(40);
  frames[3].report.frame = 13;
  frames[3].report.longest_job = std::chrono::microseconds(70);
  frames[3].longest_job_bodies = {4, 9};
  frames[4].report.longest_job = std::chrono::microseconds(60);
  const RunFigures figures = run_figures(frames, {true});
  ASSERT_TRUE(figures.longest_job);
  EXPECT_EQ(figures.longest_job->frame, 13U) << "as replays count, warm-up included";
  EXPECT_EQ(figures.longest_job->body_a, 4U);
  EXPECT_EQ(figures.longest_job->body_b, 9U);
  EXPECT_DOUBLE_EQ(figures.longest_job_ms_max, 0.07);
}

TEST(RunFigures, NamesTheFirstBodyThatLeftTheRangeWarmUpIncluded) {
  std::vector<RunFrame> frames(4, frame_of(milliseconds(10)));
  EXPECT_EQ(run_figures(frames, {true}).out_of_range.bodies, 0U);
  frames[0].warm_up = true;
  for (const std::size_t k : {0U, 2U}) {
    frames[k].report.frame = 20 + k;
    frames[k].report.out_of_range = 3;
    frames[k].out_of_range_body = 7 + k;
  }
  const OutOfRangeFigures out = run_figures(frames, {true}).out_of_range;
  EXPECT_EQ(out.bodies, 6U);
  EXPECT_EQ(out.first_frame, 20U);
  EXPECT_EQ(out.first_body, 7U);
}

TEST(RunFigures, NamesTheLatestFramesWithCauseAndLongestStage) {
  std::vector<RunFrame> frames(10, frame_of(milliseconds(10)));
  EXPECT_TRUE(run_figures(frames, {true}).worst_frames.empty());
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].report.frame = 100 + i;
  const int late_ms[] = {1, 9, 0, 3, 3, 50, 2, 4};
  for (std::size_t i = 0; i < std::size(late_ms); ++i) {
    frames[i].report.lateness = milliseconds(late_ms[i]);
    frames[i].report.cause = late_ms[i] > 0 ? MissCause::Forecast : MissCause::None;
    frames[i].report.times.solve = milliseconds(7);
    frames[i].report.longest_job = microseconds(800);
    frames[i].longest_job_bodies = {4, 6};
  }
  frames[5].warm_up = true;
  frames[1].report.cause = MissCause::Overrun;
  frames[1].report.times.refine = milliseconds(8);
  frames[7].report.host_actual = milliseconds(12);
  frames[7].report.release_delay = milliseconds(2);
  const std::vector<WorstFrame> worst = run_figures(frames, {true}).worst_frames;
  ASSERT_EQ(worst.size(), 5U);
  const std::uint64_t expected[] = {101, 107, 103, 104, 106};
  for (std::size_t i = 0; i < worst.size(); ++i) EXPECT_EQ(worst[i].frame, expected[i]) << i;
  EXPECT_EQ(worst[0].lateness, milliseconds(9));
  EXPECT_EQ(worst[0].cause, MissCause::Overrun);
  EXPECT_STREQ(worst[0].stage, "refine");
  EXPECT_EQ(worst[0].stage_time, milliseconds(8));
  ASSERT_TRUE(worst[0].piece);
  EXPECT_EQ(worst[0].piece->body_a, 4U);
  EXPECT_EQ(worst[0].piece->body_b, 6U);
  EXPECT_EQ(worst[0].piece_time, microseconds(800));
  EXPECT_STREQ(worst[1].stage, "host");
  EXPECT_EQ(worst[1].release_delay, milliseconds(2));
  EXPECT_FALSE(worst[1].piece) << "it was not the cause";
  EXPECT_STREQ(worst[2].stage, "solve");
  EXPECT_TRUE(run_figures(frames, {false}).worst_frames.empty()) << "nothing is late on the work clock";
}

TEST(LateRelease, IsTheFaultOfWhatRanThenOrOfTheMachine) {
  EXPECT_EQ(cause_of_release(MissCause::Overrun, false), MissCause::Overrun);
  EXPECT_EQ(cause_of_release(MissCause::Machine, false), MissCause::Machine);
  EXPECT_EQ(cause_of_release(MissCause::Overrun, true), MissCause::Machine) << "that frame was over by then";
  EXPECT_EQ(cause_of_release(MissCause::None, true), MissCause::Machine);
  EXPECT_EQ(cause_of_release(MissCause::None, false), MissCause::Release);
}

}  // namespace
}  // namespace poise::simulation
