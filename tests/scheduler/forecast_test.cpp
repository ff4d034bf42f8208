// SPDX-License-Identifier: MIT
#include "poise/scheduler/forecast.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace poise::scheduler {
namespace {

using std::chrono::microseconds;

Nanoseconds true_cost(const TailWork& work) {
  return Nanoseconds(50'000 + 70 * static_cast<std::int64_t>(work.bodies) +
                     350 * static_cast<std::int64_t>(work.contacts) +
                     10 * static_cast<std::int64_t>(work.candidate_pairs));
}

TailWork work_at(std::mt19937_64& random) {
  return {500 + random() % 2000, 100 + random() % 9000, 2000 + random() % 20000, 0};
}

TEST(Forecast, LearnsACostThatIsLinearInCountedWork) {
  std::mt19937_64 random(3);
  TailForecast forecast;
  for (int frame = 0; frame < 200; ++frame) {
    const TailWork work = work_at(random);
    forecast.learn(work, true_cost(work));
  }
  for (int probe = 0; probe < 50; ++probe) {
    const TailWork work = work_at(random);
    const auto expected = static_cast<double>(true_cost(work).count());
    EXPECT_NEAR(static_cast<double>(forecast.forecast(work).count()), expected, 0.01 * expected);
  }
}

TEST(Forecast, StaysSoundWhenTheWorkNeverVaries) {
  TailForecast forecast;
  const TailWork same{1000, 3000, 9000, 0};
  for (int frame = 0; frame < 100'000; ++frame) forecast.learn(same, microseconds(1500));
  EXPECT_NEAR(static_cast<double>(forecast.forecast(same).count()), 1.5e6, 1e4);
  // The forecast follows a machine that suddenly becomes twice as slow.
  for (int frame = 0; frame < 300; ++frame) forecast.learn(same, microseconds(3000));
  EXPECT_NEAR(static_cast<double>(forecast.forecast(same).count()), 3.0e6, 1e5);
}

TEST(Forecast, OneDisturbedFrameDoesNotRuinIt) {
  TailForecast forecast;
  const TailWork same{1000, 3000, 9000, 0};
  for (int frame = 0; frame < 200; ++frame) forecast.learn(same, microseconds(1500));
  forecast.learn(same, std::chrono::seconds(2));
  EXPECT_LT(forecast.forecast(same), microseconds(4600));
}

TEST(Forecast, IsNeverNegative) {
  TailForecast forecast;
  for (int frame = 0; frame < 50; ++frame) forecast.learn({5000, 0, 0, 0}, microseconds(1));
  EXPECT_GT(forecast.forecast({0, 100, 0, 0}).count(), 0);
  EXPECT_GT(forecast.forecast({}).count(), 0);
}

// The bound of the header, for any sequence of ratios within the clip, also for sequences chosen against the tracker.
void expect_within_bound(const std::vector<double>& logs, double alpha, double eta) {
  TrackedQuantile margin(alpha, eta, 0.0);
  const Nanoseconds forecast(1'000'000);
  for (const double z : logs) margin.observe(Nanoseconds(static_cast<std::int64_t>(1e6 * std::exp(z))), forecast);
  const double frames = static_cast<double>(logs.size());
  const double rate = static_cast<double>(margin.exceeded()) / frames;
  const double bound = (TrackedQuantile::kHigh - TrackedQuantile::kLow + eta) / (eta * frames);
  EXPECT_LE(std::abs(rate - alpha), bound + 1e-9);
}

RC_GTEST_PROP(Forecast, TheMissRateKeepsItsBoundForAnyRatiosWithinTheClip, ()) {
  const double alpha = *rc::gen::element(0.001, 0.01, 0.1);
  const double eta = *rc::gen::element(0.02, 0.05, 0.2);
  const auto raw = *rc::gen::container<std::vector<int>>(2000, rc::gen::inRange(0, 1000));
  std::vector<double> logs;
  for (const int r : raw) {
    logs.push_back(TrackedQuantile::kLow + 0.01 + (TrackedQuantile::kHigh - TrackedQuantile::kLow - 0.02) * r / 999.0);
  }
  expect_within_bound(logs, alpha, eta);
}

TEST(Forecast, TheMissRateKeepsItsBoundAgainstAnAdversary) {
  for (const double alpha : {0.001, 0.01, 0.1}) {
    const double eta = 0.05;
    TrackedQuantile margin(alpha, eta, 0.0);
    const int frames = 20'000;
    for (int frame = 0; frame < frames; ++frame) {
      // Always just above the reserve, as far as the clip permits.
      const double z = std::min(margin.log_quantile() + 1e-4, TrackedQuantile::kHigh - 1e-3);
      margin.observe(Nanoseconds(static_cast<std::int64_t>(1e9 * std::exp(z))), Nanoseconds(1'000'000'000));
    }
    const double rate = static_cast<double>(margin.exceeded()) / frames;
    EXPECT_LE(rate, alpha + (TrackedQuantile::kHigh - TrackedQuantile::kLow + eta) / (eta * frames));
  }
}

RC_GTEST_PROP(Forecast, TheMissRateKeepsItsBoundAgainstAnyMixOfAdversaries, ()) {
  // Blocks of ratios that are chosen with knowledge of the tracker: just above it, just below it, as far away as the
  // clip permits, or at random.
  const double alpha = *rc::gen::element(0.001, 0.01, 0.05, 0.3);
  const double eta = *rc::gen::element(0.01, 0.05, 0.2, 1.0);
  const double start =
      TrackedQuantile::kLow + (TrackedQuantile::kHigh - TrackedQuantile::kLow) * *rc::gen::inRange(0, 1001) * 1e-3;
  const auto blocks = *rc::gen::container<std::vector<int>>(20, rc::gen::inRange(0, 5));
  const auto block_frames = *rc::gen::inRange(1, 200);
  TrackedQuantile margin(alpha, eta, start);
  constexpr double kEdge = 1e-3;
  const Nanoseconds forecast(1'000'000'000);
  std::uint64_t noise = 1;
  for (const int kind : blocks) {
    for (int frame = 0; frame < block_frames; ++frame) {
      noise = noise * 6364136223846793005ULL + 1442695040888963407ULL;
      const double q = margin.log_quantile();
      double z = TrackedQuantile::kLow +
                 (TrackedQuantile::kHigh - TrackedQuantile::kLow) * static_cast<double>(noise >> 40U) * 0x1p-24;
      if (kind == 0) z = q + 1e-4;
      if (kind == 1) z = q - 1e-4;
      if (kind == 2) z = TrackedQuantile::kHigh;
      if (kind == 3) z = TrackedQuantile::kLow;
      z = std::clamp(z, TrackedQuantile::kLow + kEdge, TrackedQuantile::kHigh - kEdge);
      margin.observe(Nanoseconds(static_cast<std::int64_t>(1e9 * std::exp(z))), forecast);
      const double seen = static_cast<double>(margin.observed());
      const double bound = (TrackedQuantile::kHigh - TrackedQuantile::kLow + eta) / (eta * seen);
      RC_ASSERT(std::abs(static_cast<double>(margin.exceeded()) / seen - alpha) <= bound + 1e-9);
    }
  }
  RC_ASSERT(margin.beyond_clip() == 0U);
}

TEST(Forecast, TheStepFollowsTheSpreadOfTheRatios) {
  EXPECT_EQ(TrackedQuantile::eta_for(0), TrackedQuantile::kDefaultEta) << "nothing is known";
  EXPECT_DOUBLE_EQ(TrackedQuantile::eta_for(0.1), 0.05);
  EXPECT_DOUBLE_EQ(TrackedQuantile::eta_for(1e-6), 0.01);
  EXPECT_DOUBLE_EQ(TrackedQuantile::eta_for(5), 0.2);
  // Ratios that vary by a tenth around one and a half have a spread of a tenth.
  TrackedQuantile margin;
  for (int frame = 0; frame < 3000; ++frame)
    margin.observe(Nanoseconds(static_cast<std::int64_t>(1.5e9 * std::exp(frame % 2 == 0 ? 0.1 : -0.1))),
                   Nanoseconds(1'000'000'000));
  EXPECT_NEAR(margin.spread(), 0.1, 0.005);
}

TEST(Forecast, BeginsFromWhatAnotherRunLearnedAndRefusesWhatMakesNoSense) {
  const TailForecast::Features learned = {10, 1, 2, 3, 4, 5, 6};
  const TailForecast forecast(learned);
  EXPECT_EQ(forecast.coefficients_us(), learned);
  EXPECT_EQ(forecast.forecast({1000, 1000, 1000, 1000, 1000, 1000}), microseconds(10 + 1 + 2 + 3 + 4 + 5 + 6));
  TailForecast::Features negative = learned;
  negative[2] = -1;
  EXPECT_EQ(TailForecast(negative).coefficients_us(), TailForecast().coefficients_us());
  TailForecast::Features infinite = learned;
  infinite[6] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(TailForecast(infinite).coefficients_us(), TailForecast().coefficients_us());
  // Learned values of another run may be wrong here: they are corrected as the built-in priors are.
  TailForecast here(learned);
  for (int frame = 0; frame < 300; ++frame) here.learn({1000, 3000, 9000, 0}, microseconds(1500));
  EXPECT_NEAR(static_cast<double>(here.forecast({1000, 3000, 9000, 0}).count()), 1.5e6, 3e4);
}

TEST(Forecast, RatiosBeyondTheClipAreCounted) {
  EXPECT_FALSE(beyond_clip(microseconds(7), microseconds(1)));
  EXPECT_TRUE(beyond_clip(microseconds(9), microseconds(1)));
  EXPECT_FALSE(beyond_clip(microseconds(1), microseconds(3)));
  EXPECT_TRUE(beyond_clip(microseconds(1), microseconds(5)));
  EXPECT_TRUE(beyond_clip(microseconds(1), microseconds(0)));
  TrackedQuantile margin;
  margin.observe(std::chrono::seconds(1), microseconds(1));
  margin.observe(microseconds(1), microseconds(1));
  EXPECT_EQ(margin.beyond_clip(), 1U);
  EXPECT_EQ(margin.observed(), 2U);
}

TEST(Forecast, SettingsThatAreNoNumbersAreTheirLowerEnds) {
  constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
  const TrackedQuantile quantile(kNoNumber, kNoNumber, kNoNumber);
  EXPECT_EQ(quantile.alpha(), 1e-6);
  EXPECT_EQ(quantile.eta(), 1e-6);
  EXPECT_EQ(quantile.log_quantile(), TrackedQuantile::kLow);
}

TEST(Forecast, HostWorkIsReservedWithAMarginOnceItIsKnown) {
  DurationForecast host;
  EXPECT_EQ(host.reserve().count(), 0);
  for (int frame = 0; frame < 100; ++frame) host.learn(microseconds(2000 + 100 * (frame % 3)));
  EXPECT_GT(host.reserve(), microseconds(2000));
  EXPECT_LT(host.reserve(), microseconds(4000));
}

}  // namespace
}  // namespace poise::scheduler
