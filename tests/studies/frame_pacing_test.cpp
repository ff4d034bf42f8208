// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "scene/run/release_grid.h"
#include "scene/run/render_load.h"
#include "studies/forecast_trial.h"

// All times are invented, except one that is measured on this thread.
namespace poise::simulation {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

const SteadyClock::time_point kStart{std::chrono::hours(3)};

TEST(ReleaseGrid, ALateFrameLeavesTheNextOneWhatIsLeftOfItsPeriodAndNoMore) {
  ReleaseGrid grid(kStart, 0.010, milliseconds(10));
  EXPECT_EQ(grid.release(), kStart);
  EXPECT_EQ(grid.advance(kStart + milliseconds(13)), 0U);
  EXPECT_EQ(grid.release(), kStart + milliseconds(10)) << "the grid did not move";
  EXPECT_EQ(grid.deadline(), kStart + milliseconds(20));
  // It catches up, and the next frame has its whole period.
  EXPECT_EQ(grid.advance(kStart + milliseconds(19)), 0U);
  EXPECT_EQ(grid.release(), kStart + milliseconds(20));
}

TEST(ReleaseGrid, ReleasesThatCannotBeServedAnyMoreAreCountedAndSkipped) {
  ReleaseGrid grid(kStart, 0.010, milliseconds(10));
  EXPECT_EQ(grid.advance(kStart + milliseconds(47)), 3U);
  EXPECT_EQ(grid.release(), kStart + milliseconds(40));
  EXPECT_EQ(grid.deadline(), kStart + milliseconds(50));
}

TEST(ReleaseGrid, LatenessDoesNotAddUpOverThousandsOfFrames) {
  // Each frame takes a tenth longer than its period: about one release in ten is skipped, and no frame starts later
  // than one period late.
  ReleaseGrid grid(kStart, 0.010, milliseconds(10));
  SteadyClock::time_point now = kStart;
  std::uint64_t skipped = 0;
  constexpr int kFrames = 5000;
  for (int frame = 0; frame < kFrames; ++frame) {
    now = std::max(now, grid.release()) + milliseconds(11);
    skipped += grid.advance(now);
    EXPECT_LT(now - grid.release(), milliseconds(10));
  }
  EXPECT_NEAR(static_cast<double>(skipped), 0.1 * kFrames, 0.01 * kFrames);
  // The load falls: the next frame is on time.
  now = std::max(now, grid.release()) + milliseconds(1);
  EXPECT_LT(now, grid.deadline());
  grid.advance(now);
  EXPECT_GE(grid.release(), now - milliseconds(10));
}

// The release that is served is the first one that can be met, whatever the ratio of times; it is not looked for one by
// one, which took ten minutes for the second of these steps.
TEST(ReleaseGrid, FindsTheFirstReleaseThatCanBeMetForAnyStep) {
  for (const double dt_s : {1e-7, 1e-12, 1e-300, 1.0}) {
    for (const Nanoseconds deadline : {Nanoseconds(3), Nanoseconds(milliseconds(1)), Nanoseconds(milliseconds(2000))}) {
      ReleaseGrid grid(kStart, dt_s, deadline);
      const SteadyClock::time_point now = kStart + milliseconds(1500);
      const std::uint64_t skipped = grid.advance(now);
      if (dt_s < 1e-200) {
        EXPECT_EQ(grid.release(), kStart) << "all releases are at the begin";
        continue;
      }
      EXPECT_GT(grid.deadline(), now);
      // The one before would have been late, or its period was over; releases are whole nanoseconds.
      const double before_s = dt_s * static_cast<double>(skipped);
      const double now_s = 1.5 + 1e-9;
      const bool first =
          skipped == 0 || before_s + 1e-9 * static_cast<double>(deadline.count()) <= now_s || before_s + dt_s <= now_s;
      EXPECT_TRUE(first) << dt_s << ' ' << deadline.count() << ' ' << skipped;
      EXPECT_EQ(grid.advance(now), 0U) << "it moves on by one";
    }
  }
  ReleaseGrid grid(kStart, 1e-7, Nanoseconds(50));
  EXPECT_EQ(grid.advance(kStart + microseconds(10)), 99U);
  EXPECT_EQ(grid.release(), kStart + microseconds(10)) << "the deadline of the one before is 50 ns ago";
}

TEST(RenderLoad, IsTheSameForAFrameAndStaysWithinItsJitter) {
  const RenderLoad load{milliseconds(4), milliseconds(1), 7};
  Nanoseconds least = milliseconds(9);
  Nanoseconds most{0};
  for (std::uint64_t frame = 0; frame < 500; ++frame) {
    const Nanoseconds time = load_of(load, frame);
    EXPECT_EQ(time, load_of(load, frame));
    least = std::min(least, time);
    most = std::max(most, time);
  }
  EXPECT_GE(least, milliseconds(3));
  EXPECT_LT(least, microseconds(3100));
  EXPECT_LE(most, milliseconds(5));
  EXPECT_GT(most, microseconds(4900));
  EXPECT_EQ(load_of({milliseconds(1), milliseconds(5), 1}, 3), load_of({milliseconds(1), milliseconds(1), 1}, 3))
      << "never negative";
}

TEST(RenderLoad, KeepsTheProcessorForAsLongAsItSays) {
  const LoadTime load = burn(milliseconds(3));
  EXPECT_GE(load.wall - load.off_cpu, milliseconds(3));
  EXPECT_GE(load.off_cpu.count(), 0);
}

RecordedTail tail_of(std::uint64_t contacts, std::uint64_t iterations, Nanoseconds actual) {
  RecordedTail tail;
  tail.forecast_for.bodies = 100;
  tail.forecast_for.contacts = contacts;
  tail.forecast_for.point_iterations = iterations;
  tail.contacts = contacts;
  tail.actual = actual;
  return tail;
}

TEST(ForecastTrial, AConstantTailIsExactlyItsMean) {
  const std::vector<RecordedTail> tails(400, tail_of(50, 100, microseconds(700)));
  const std::vector<ForecastScore> scores = try_forecasts(tails, 0.01, 100);
  ASSERT_EQ(scores.size(), 5U);
  for (const ForecastScore& score : scores) {
    if (score.method.starts_with("mean") || score.method.starts_with("quantile")) {
      EXPECT_EQ(score.exceeded, 0) << score.method;
      EXPECT_NEAR(score.reserve_over_actual, 1, 1e-9) << score.method;
      EXPECT_NEAR(score.pinball, 0, 1e-9) << score.method;
    }
  }
}

TEST(ForecastTrial, WorkThatRepeatsFromFrameToFrameIsForeseenByItsCounts) {
  // Contact points that vary independently of the other counts: the contacts carry no information, the points of the
  // previous frame carry all of it.
  std::vector<RecordedTail> tails;
  for (int i = 0; i < 1500; ++i) {
    const std::uint64_t iterations = (i / 40) % 2 == 0 ? 2000 : 20000;
    tails.push_back(tail_of(300, iterations, microseconds(200) + Nanoseconds(50 * iterations)));
  }
  const std::vector<ForecastScore> scores = try_forecasts(tails, 0.01, 200);
  ASSERT_TRUE(scores.back().method.starts_with("quantile"));
  EXPECT_LT(scores[0].reserve_over_actual, 0.75 * scores.back().reserve_over_actual);
  EXPECT_LT(scores[0].pinball, 0.5 * scores.back().pinball);
  EXPECT_LE(scores[0].exceeded, 0.03);
}

TEST(ForecastTrial, FramesThatAreNotJudgedAreStillLearnedFrom) {
  std::vector<RecordedTail> tails(100, tail_of(10, 10, microseconds(100)));
  tails.back().actual = microseconds(900);
  EXPECT_EQ(try_forecasts(tails, 0.01, 100)[2].exceeded, 0) << "none is counted";
  EXPECT_EQ(try_forecasts(tails, 0.01, 99)[2].exceeded, 1) << "the last one alone";
}

TEST(ForecastTrial, TakesTheTailsOfMeasuredFramesThatHadSomethingToDo) {
  std::vector<RunFrame> frames(5);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].report.contact_pairs = static_cast<std::uint32_t>(i);
    frames[i].report.tail_actual = microseconds(1000);
    frames[i].report.tail_optional = microseconds(300);
  }
  frames[0].warm_up = true;
  frames[2].report.tail_optional = microseconds(1000);
  frames[3].report.off_cpu = microseconds(31);
  const std::vector<RecordedTail> all = recorded_tails(frames, false);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].contacts, 1U);
  EXPECT_EQ(all[1].contacts, 3U);
  EXPECT_EQ(all[2].contacts, 4U);
  EXPECT_EQ(all[0].actual, microseconds(700));
  const std::vector<RecordedTail> undisturbed = recorded_tails(frames, true);
  ASSERT_EQ(undisturbed.size(), 2U);
  EXPECT_EQ(undisturbed[1].contacts, 4U);
}

}  // namespace
}  // namespace poise::simulation
