// SPDX-License-Identifier: MIT
#include "scene/generators.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/primitives/random.h"
#include "scene/scene_text.h"

namespace poise::io {
namespace {

using geometry::Random;

using testing::parse;
using testing::scene_text;

Scene scene_with(const std::string& generators, const std::string& more = "") {
  const Result<Scene> scene = parse(scene_text(more + "\"generators\": [" + generators + "], "));
  EXPECT_TRUE(scene) << scene.error().message;
  return scene.value();
}

std::vector<GeneratedBody> expand(const Scene& scene, std::optional<std::uint64_t> bodies = {},
                                  std::uint64_t seed = 1) {
  const std::vector<double> radius_m(scene.shapes.size(), 0.5);
  ExpandOptions options{bodies, seed, radius_m,
                        tray_side_m(scene, bodies.value_or(generated_body_count(scene)), radius_m)};
  Result<std::vector<GeneratedBody>> made = expand_generators(scene, options);
  EXPECT_TRUE(made) << made.error().message;
  return made ? std::move(made).value() : std::vector<GeneratedBody>{};
}

const char* const kGrid =
    R"({"grid": {"shape": "ball", "material": "hard", "count": [3, 2, 4], "spacing_m": 2, "origin_m": [10, 20, 30]}})";

TEST(Grid, CountsXFirstThenYThenZ) {
  const Scene scene = scene_with(kGrid);
  const std::vector<GeneratedBody> bodies = expand(scene);
  ASSERT_EQ(bodies.size(), 24U);
  EXPECT_EQ(bodies[0].center_m, Vec3(10, 20, 30));
  EXPECT_EQ(bodies[2].center_m, Vec3(14, 20, 30));
  EXPECT_EQ(bodies[3].center_m, Vec3(10, 22, 30));
  EXPECT_EQ(bodies[6].center_m, Vec3(10, 20, 32));
  EXPECT_EQ(bodies[23].center_m, Vec3(14, 22, 36));
}

TEST(Grid, KeepsItsFootprintWhenTheNumberIsChosen) {
  const Scene scene = scene_with(kGrid);
  EXPECT_EQ(expand(scene, 7).back().center_m, Vec3(10, 20, 32));
  EXPECT_EQ(expand(scene, 31).back().center_m, Vec3(10, 20, 40));
  EXPECT_EQ(expand(scene, 1).size(), 1U);
}

TEST(Grid, IsRepeatedInBlocksOneAfterTheOther) {
  const Scene scene = scene_with(
      R"({"grid": {"shape": "ball", "material": "hard", "count": [2, 1, 2], "spacing_m": 2, "origin_m": [10, 20, 30],
                   "blocks": {"count": [3, 2], "spacing_m": [100, 50]}}})");
  EXPECT_EQ(generated_body_count(scene), 24U);
  const std::vector<GeneratedBody> bodies = expand(scene);
  ASSERT_EQ(bodies.size(), 24U);
  EXPECT_EQ(bodies[3].center_m, Vec3(12, 20, 32));
  EXPECT_EQ(bodies[4].center_m, Vec3(110, 20, 30));
  EXPECT_EQ(bodies[8].center_m, Vec3(210, 20, 30));
  EXPECT_EQ(bodies[12].center_m, Vec3(10, 70, 30));
  EXPECT_EQ(bodies[23].center_m, Vec3(212, 70, 32));
}

TEST(Grid, KeepsItsBlocksAndGetsFewerOrMoreRowsOfThem) {
  const Scene scene = scene_with(
      R"({"grid": {"shape": "ball", "material": "hard", "count": [2, 1, 2], "spacing_m": 2, "jitter_m": 0.5,
                   "blocks": {"count": [3, 2], "spacing_m": [100, 50]}}})");
  const std::vector<GeneratedBody> own = expand(scene);
  const std::vector<GeneratedBody> fewer = expand(scene, 7);
  const std::vector<GeneratedBody> more = expand(scene, 25);
  ASSERT_EQ(fewer.size(), 7U);
  for (std::size_t i = 0; i < fewer.size(); ++i) EXPECT_EQ(fewer[i].center_m, own[i].center_m);
  EXPECT_NEAR((more[24].center_m - Vec3(0, 100, 0)).lpNorm<Eigen::Infinity>(), 0, 0.5);
}

TEST(Grid, MakesStaticBodiesWhereItSaysSo) {
  const Scene scene = scene_with(
      R"({"grid": {"shape": "ball", "material": "hard", "static": true, "count": [2, 1, 1], "spacing_m": 2}}, )" +
      std::string(kGrid));
  const std::vector<GeneratedBody> bodies = expand(scene);
  for (std::size_t i = 0; i < bodies.size(); ++i) EXPECT_EQ(bodies[i].is_static, i < 2) << i;
}

TEST(Grid, JittersWithinItsBoundAndTheSameEveryTime) {
  const Scene scene = scene_with(
      R"({"grid": {"shape": "ball", "material": "hard", "count": [20, 20, 5], "spacing_m": 2, "jitter_m": 0.25, "random_orientation": true, "speed_mps": 3, "spin_radps": 2}})");
  const std::vector<GeneratedBody> bodies = expand(scene);
  const std::vector<GeneratedBody> again = expand(scene);
  const std::vector<GeneratedBody> fewer = expand(scene, 50);
  const std::vector<GeneratedBody> other = expand(scene, {}, 2);
  double largest = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Vec3 cell(static_cast<double>(i % 20), static_cast<double>(i / 20 % 20), static_cast<double>(i / 400));
    largest = std::max(largest, (bodies[i].center_m - 2 * cell).lpNorm<Eigen::Infinity>());
    EXPECT_EQ(bodies[i].center_m, again[i].center_m);
    EXPECT_EQ(bodies[i].orientation.coeffs(), again[i].orientation.coeffs());
    EXPECT_NEAR(bodies[i].orientation.norm(), 1, 1e-14);
    EXPECT_NEAR(bodies[i].velocity_mps.norm(), 3, 1e-14);
    EXPECT_NEAR(bodies[i].angular_velocity_radps.norm(), 2, 1e-14);
    if (i < fewer.size()) {
      EXPECT_EQ(bodies[i].center_m, fewer[i].center_m);
    }
    EXPECT_NE(bodies[i].center_m, other[i].center_m);
  }
  EXPECT_LE(largest, 0.25);
  EXPECT_GT(largest, 0.24);
}

TEST(Grid, MixesShapesInTurnOrBySeed) {
  const auto scene_mix = [](const std::string& mix) {
    const std::string text =
        R"({"name": "x", "dt_s": 1, "materials": {"m": {}}, "shapes": {"a": {"sphere": {"radius_m": 1}}, "b": {"sphere": {"radius_m": 1}}},
      "generators": [{"grid": {"shapes": ["a", "b"], "mix": ")" +
        mix + R"(", "material": "m", "count": [1000, 1, 1], "spacing_m": 3}}]})";
    return parse(text).value();
  };
  const Scene turn = scene_mix("cycle");
  const std::vector<GeneratedBody> in_turn = expand(turn);
  for (std::size_t i = 0; i < in_turn.size(); ++i) EXPECT_EQ(in_turn[i].shape, i % 2);
  const Scene seed = scene_mix("seed");
  std::size_t second = 0;
  std::size_t changes = 0;
  const std::vector<GeneratedBody> drawn = expand(seed);
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    second += drawn[i].shape;
    if (i > 0 && drawn[i].shape != drawn[i - 1].shape) ++changes;
  }
  // Six standard deviations of a fair coin: 500 +- 95.
  EXPECT_NEAR(static_cast<double>(second), 500, 95);
  EXPECT_NEAR(static_cast<double>(changes), 500, 95);
}

TEST(TrayGrid, FillsLayersInsideTheWallsAboveTheFloor) {
  const Scene scene = scene_with(
      R"({"grid": {"shape": "ball", "material": "hard", "in_tray": true, "bodies": 2000, "spacing_m": 1.9, "bottom_m": 0.2, "jitter_m": 0.04}})",
      R"("tray": {"material": "hard", "side_per_sqrt_body_m": 0.4695742752749558}, )");
  for (const std::uint64_t n : {10U, 200U, 2000U, 20000U}) {
    const std::vector<GeneratedBody> bodies = expand(scene, n);
    ASSERT_EQ(bodies.size(), n);
    const double side_m = 1.05 * std::sqrt(static_cast<double>(n) / 5);
    EXPECT_NEAR(tray_side_m(scene, n, std::vector<double>(2, 0.5)), side_m, 1e-12 * side_m);
    double lowest = 1e9;
    double widest = 0;
    for (const GeneratedBody& body : bodies) {
      lowest = std::min(lowest, body.center_m.z() - 0.5);
      widest = std::max(widest, body.center_m.head<2>().lpNorm<Eigen::Infinity>() + 0.5);
    }
    EXPECT_GE(lowest, 0.2);
    EXPECT_LE(lowest, 0.2 + 0.08);
    EXPECT_LE(widest, 0.5 * side_m);
    // One more row across would not fit.
    EXPECT_GT(widest, 0.5 * side_m - 0.5 * 1.9 - 0.08);
  }
}

TEST(TrayGrid, GrowsItsTrayToHoldOneBodyWhereTheFormulaGivesLess) {
  const Scene scene = scene_with(
      R"({"grid": {"shape": "ball", "material": "hard", "in_tray": true, "bodies": 9, "spacing_m": 1, "jitter_m": 0.1}})",
      R"("tray": {"material": "hard", "side_per_sqrt_body_m": 1}, )");
  const std::vector<double> radius_m(2, 0.5);
  EXPECT_EQ(tray_side_m(scene, 9, radius_m), 3);
  EXPECT_EQ(tray_side_m(scene, 1, radius_m), 1.2);
  EXPECT_EQ(expand(scene, 1).size(), 1U);
}

TEST(TrayGrid, RefusesATrayThatHoldsNoBody) {
  const Scene scene =
      scene_with(R"({"grid": {"shape": "ball", "material": "hard", "in_tray": true, "bodies": 4, "spacing_m": 1}})",
                 R"("tray": {"material": "hard", "side_m": 0.9}, )");
  const std::vector<double> radius_m(2, 0.5);
  const Result<std::vector<GeneratedBody>> made = expand_generators(scene, {{}, 1, radius_m, 0.9});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().message,
            "s.json: generators[0].grid.in_tray: a tray of side 0.9 m is too small for a body of radius 0.5 m with "
            "jitter 0 m");
}

TEST(Stream, SpreadsItsBodiesEvenlyOverItsTimeInsideItsRegion) {
  const Scene scene = scene_with(
      R"({"stream": {"shape": "ball", "material": "hard", "per_second": 4, "from_s": 1, "to_s": 3, "region_min_m": [0, 1, 2], "region_max_m": [1, 1, 4]}})");
  const std::vector<GeneratedBody> bodies = expand(scene);
  ASSERT_EQ(bodies.size(), 8U);
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    EXPECT_TRUE(bodies[k].streamed);
    EXPECT_EQ(bodies[k].due_s, 1 + 0.25 * static_cast<double>(k));
    EXPECT_TRUE((bodies[k].center_m.array() >= Vec3(0, 1, 2).array()).all());
    EXPECT_TRUE((bodies[k].center_m.array() <= Vec3(1, 1, 4).array()).all());
  }
  EXPECT_EQ(expand(scene, 2)[1].due_s, 2);
}

TEST(ShareBodies, GivesExactlyTheTotalInProportion) {
  EXPECT_EQ(share_bodies(std::vector<std::uint64_t>{1, 1, 1}, 10), (std::vector<std::uint64_t>{4, 3, 3}));
  EXPECT_EQ(share_bodies(std::vector<std::uint64_t>{3, 1}, 8), (std::vector<std::uint64_t>{6, 2}));
  rc::check("shares sum to the total and differ from proportion by less than one", [] {
    const auto own = *rc::gen::nonEmpty(
        rc::gen::container<std::vector<std::uint64_t>>(rc::gen::inRange<std::uint64_t>(1, 1'000'000)));
    const auto total = *rc::gen::inRange<std::uint64_t>(1, kMaxSceneBodies);
    const std::vector<std::uint64_t> shares = share_bodies(own, total);
    const auto sum = static_cast<double>(std::accumulate(own.begin(), own.end(), std::uint64_t{0}));
    RC_ASSERT(std::accumulate(shares.begin(), shares.end(), std::uint64_t{0}) == total);
    for (std::size_t i = 0; i < own.size(); ++i) {
      const double exact = static_cast<double>(own[i]) * static_cast<double>(total) / sum;
      RC_ASSERT(std::abs(static_cast<double>(shares[i]) - exact) <= 1.0);
    }
  });
}

// Reference values of SplitMix64 for seed 0, published with the generator.
TEST(Random, IsTheGeneratorThatItSaysItIs) {
  Random random(0);
  EXPECT_EQ(random.next(), 0xe220a8397b1dcdafULL);
  EXPECT_EQ(random.next(), 0x6e789e6aa1b965f4ULL);
  EXPECT_EQ(random.next(), 0x06c45d188009454fULL);
}

TEST(Random, TurnsAndPointsInAllDirectionsAlike) {
  Random random(5);
  Vec3 mean = Vec3::Zero();
  Mat3 spread = Mat3::Zero();
  Mat3 turned = Mat3::Zero();
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const Vec3 d = random.direction();
    EXPECT_NEAR(d.norm(), 1, 1e-14);
    mean += d / n;
    spread += d * d.transpose() / n;
    turned += random.rotation().toRotationMatrix() / n;
  }
  // Each mean has a standard deviation of 1/sqrt(3 n) = 0.004; the bound is six of them.
  EXPECT_LT(mean.lpNorm<Eigen::Infinity>(), 0.025);
  EXPECT_LT((spread - Mat3::Identity() / 3).lpNorm<Eigen::Infinity>(), 0.025);
  EXPECT_LT(turned.lpNorm<Eigen::Infinity>(), 0.025);
}

}  // namespace
}  // namespace poise::io
