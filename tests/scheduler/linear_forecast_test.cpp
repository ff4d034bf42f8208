// SPDX-License-Identifier: MIT
#include "poise/scheduler/linear_forecast.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "poise/scheduler/forecast.h"

namespace poise::scheduler {
namespace {

using std::chrono::microseconds;

// A host that renders, with features of its own.
constexpr std::array<ForecastFeature, 3> kDrawing{{{"constant", 20}, {"triangles_k", 5}, {"lights", 50}}};

std::uint64_t drawn(std::uint64_t& noise, std::uint64_t most) {
  noise = noise * 6364136223846793005ULL + 1442695040888963407ULL;
  return (noise >> 33U) % most;
}

TEST(LinearForecast, LearnsACostThatIsLinearInFeaturesOfTheHostsChoosing) {
  LinearForecast forecast(kDrawing);
  std::uint64_t noise = 1;
  const auto cost_us = [](double triangles_k, double lights) { return 300 + 2.5 * triangles_k + 110 * lights; };
  for (int frame = 0; frame < 300; ++frame) {
    const auto triangles_k = static_cast<double>(drawn(noise, 400));
    const auto lights = static_cast<double>(drawn(noise, 8));
    EXPECT_TRUE(forecast.learn(std::array{1.0, triangles_k, lights},
                               Nanoseconds(static_cast<std::int64_t>(1e3 * cost_us(triangles_k, lights)))));
  }
  for (const double lights : {0.0, 3.0, 7.0}) {
    const double expected_ns = 1e3 * cost_us(200, lights);
    EXPECT_NEAR(static_cast<double>(forecast.forecast(std::array{1.0, 200.0, lights}).count()), expected_ns,
                0.02 * expected_ns);
  }
  const auto lights = forecast.index_of("lights");
  ASSERT_TRUE(lights.has_value());
  EXPECT_NEAR(forecast.coefficients_us()[*lights], 110, 3);
  EXPECT_EQ(forecast.name(1), "triangles_k");
  EXPECT_FALSE(forecast.index_of("bones").has_value());
}

TEST(LinearForecast, BeginsFromItsPriorsOrFromWhatAnotherRunLearned) {
  const std::array values{1.0, 10.0, 2.0};
  EXPECT_EQ(LinearForecast(kDrawing).forecast(values), microseconds(20 + 50 + 100));
  EXPECT_EQ(LinearForecast(kDrawing, std::array{1.0, 2.0, 3.0}).forecast(values), microseconds(1 + 20 + 6));
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {-1.0, infinity, std::nan("")}) {
    EXPECT_EQ(LinearForecast(kDrawing, std::array{1.0, bad, 3.0}).forecast(values), microseconds(170)) << bad;
  }
  EXPECT_EQ(LinearForecast(kDrawing, std::array{1.0, 2.0}).forecast(values), microseconds(170)) << "one is missing";
}

TEST(LinearForecast, RefusesFeaturesThatMakeNoSenseAndNamesThem) {
  const auto said = [](std::vector<ForecastFeature> features) {
    const auto problem = LinearForecast::first_problem(features);
    EXPECT_EQ(LinearForecast(features).size(), problem ? 0U : features.size());
    return problem ? text_of(*problem) : std::string();
  };
  EXPECT_EQ(said({{"a", 1}, {"b", 0}}), "");
  EXPECT_EQ(said({}), "features.size = 0, must be in [1, 16]");
  EXPECT_EQ(said(std::vector<ForecastFeature>(17, {"a", 1})), "features.size = 17, must be in [1, 16]");
  EXPECT_EQ(said({{"a", 1}, {"", 1}}), "features.name = 1, must not be empty");
  EXPECT_EQ(said({{"a", 1}, {"b", 1}, {"a", 1}}), "features.name = 2, must be unlike the others");
  EXPECT_EQ(said({{"a", -1}}), "features.prior_us = -1, must be in [0, 1e+09]");
}

TEST(LinearForecast, PromisesNothingOnValuesThatMakeNoSense) {
  LinearForecast forecast(kDrawing);
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {-1.0, infinity, std::nan(""), 2e12}) {
    EXPECT_EQ(forecast.forecast(std::array{1.0, bad, 1.0}), Nanoseconds::max()) << bad;
    EXPECT_FALSE(forecast.learn(std::array{1.0, bad, 1.0}, microseconds(5)));
  }
  EXPECT_EQ(forecast.forecast(std::array{1.0, 1.0}), Nanoseconds::max());
  EXPECT_FALSE(forecast.learn(std::array{1.0, 1.0, 1.0}, microseconds(-5)));
  EXPECT_EQ(forecast.forecast(std::array{1.0, 0.0, 0.0}), microseconds(20)) << "nothing of it was learned";
}

RC_GTEST_PROP(LinearForecast, StaysANumberWhateverItIsFed, ()) {
  LinearForecast forecast(kDrawing);
  for (int frame = 0; frame < 60; ++frame) {
    std::array<double, 3> values{};
    for (double& value : values) {
      value = *rc::gen::element(std::bit_cast<double>(*rc::gen::arbitrary<std::uint64_t>()), 0.0, 1.0, 1e-300, 1e12);
    }
    forecast.learn(values, Nanoseconds(*rc::gen::element<std::int64_t>(0, 1, 1'000'000, INT64_MAX, INT64_MIN)));
    for (const double us : forecast.coefficients_us()) RC_ASSERT(std::isfinite(us) && us >= 0);
    RC_ASSERT(forecast.forecast(values).count() >= 1000);
  }
}

RC_GTEST_PROP(LinearForecast, WithAMarginKeepsTheBoundOfTheTrackedQuantile, ()) {
  // A host's features, with costs that drift and spike: after every frame the share of frames beyond the reserve is
  // within (b - a + eta) / (eta T) of alpha.
  const double alpha = *rc::gen::element(0.01, 0.05, 0.2);
  const double eta = *rc::gen::element(0.02, 0.05, 0.2);
  std::uint64_t noise = *rc::gen::arbitrary<std::uint64_t>();
  LinearForecast forecast(kDrawing);
  TrackedQuantile margin(alpha, eta);
  std::uint64_t late = 0;
  for (int frame = 1; frame <= 1500; ++frame) {
    const std::array values{1.0, static_cast<double>(drawn(noise, 400)), static_cast<double>(drawn(noise, 8))};
    double actual_us = (60 + 4 * values[1] + 70 * values[2]) * (1 + 0.3 * std::sin(frame * 0.01));
    actual_us *= 0.8 + 0.4 * static_cast<double>(drawn(noise, 1000)) * 1e-3;
    if (drawn(noise, 50) == 0) actual_us *= 3;
    const Nanoseconds point = forecast.forecast(values);
    // The bound holds for ratios within the clip.
    const auto least = static_cast<double>(point.count()) * std::exp(TrackedQuantile::kLow + 1e-3);
    const auto most = static_cast<double>(point.count()) * std::exp(TrackedQuantile::kHigh - 1e-3);
    const Nanoseconds actual(static_cast<std::int64_t>(std::clamp(1e3 * actual_us, least, most)));
    if (static_cast<double>(actual.count()) > static_cast<double>(point.count()) * margin.factor()) ++late;
    margin.observe(actual, point);
    forecast.learn(values, actual);
    const double bound = (TrackedQuantile::kHigh - TrackedQuantile::kLow + eta) / (eta * frame);
    RC_ASSERT(std::abs(static_cast<double>(late) / frame - alpha) <= bound + 1e-9);
  }
  RC_ASSERT(margin.beyond_clip() == 0U);
}

TEST(TailForecast, IsALinearForecastOverNamedFeatures) {
  EXPECT_FALSE(LinearForecast::first_problem(TailForecast::features()).has_value());
  const TailForecast tail;
  EXPECT_EQ(tail.linear().index_of("contacts"), TailForecast::kContacts);
  EXPECT_EQ(tail.linear().index_of("point_iterations"), TailForecast::kPointIterations);
  EXPECT_EQ(tail.linear().index_of("coarse_contacts"), TailForecast::kCoarseContacts);
}

TEST(LinearForecast, OfCountsThatVaryTogetherStaysNearWhatTheyTake) {
  // A heap of meshes that lands, and settles: contacts and their points grow together, and take less and less time. One
  // of their costs comes to its bound; what the other has gained on its account must not stay with it. When it did, the
  // forecast rose to three times what was measured.
  TailForecast tail;
  std::uint64_t noise = 1;
  double worst = 1;
  for (int frame = 0; frame < 200; ++frame) {
    const double landed = std::min(1.0, frame / 50.0);
    const double settled = std::clamp((frame - 50) / 50.0, 0.0, 1.0);
    const auto count = [](double x) { return static_cast<std::uint64_t>(x); };
    TailWork work;
    work.bodies = 2000;
    work.contacts = count(500 + 4400 * landed) + drawn(noise, 40);
    const auto contacts = static_cast<double>(work.contacts);
    work.point_iterations = count((5.8 - 1.2 * settled) * contacts);
    work.candidate_pairs = count(2000 + 8000 * landed + 1400 * settled);
    work.coarse_contacts = count(1400 * landed * (1 - 0.97 * settled));
    const double us =
        (500 + 0.43 * contacts) * (1 - 0.35 * settled) * (0.95 + 1e-4 * static_cast<double>(drawn(noise, 1000)));
    const double ratio = 1e-3 * static_cast<double>(tail.forecast(work).count()) / us;
    if (frame >= 30) worst = std::max({worst, ratio, 1 / ratio});
    tail.learn(work, Nanoseconds(static_cast<std::int64_t>(1e3 * us)));
  }
  EXPECT_LT(worst, 1.2);
}

TEST(TailForecast, GivesTheSameBitsEverywhere) {
  std::uint64_t noise = 1;
  std::uint64_t hash = 1469598103934665603ULL;
  const auto mix = [&](std::uint64_t bits) { hash = (hash ^ bits) * 1099511628211ULL; };
  TailForecast tail;
  for (int frame = 0; frame < 2000; ++frame) {
    TailWork work;
    work.bodies = drawn(noise, 20'000);
    work.contacts = drawn(noise, 60'000);
    work.candidate_pairs = drawn(noise, 200'000);
    work.sphere_contacts = drawn(noise, 50'000);
    work.point_iterations = drawn(noise, 900'000);
    work.coarse_contacts = drawn(noise, 3000);
    mix(static_cast<std::uint64_t>(tail.forecast(work).count()));
    const std::uint64_t actual_ns = 100'000 + 90 * work.bodies + 200 * work.contacts + drawn(noise, 3'000'000);
    tail.learn(work, Nanoseconds(static_cast<std::int64_t>(actual_ns)));
    // The features that there were then.
    for (std::size_t k = 0; k < 7; ++k) mix(std::bit_cast<std::uint64_t>(tail.coefficients_us()[k]));
  }
  EXPECT_EQ(hash, 10277413215154927097ULL);
}

}  // namespace
}  // namespace poise::scheduler
