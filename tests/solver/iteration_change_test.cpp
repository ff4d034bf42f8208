// SPDX-License-Identifier: MIT
#include "solver/iterations/iteration_change.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "solver/contact_bench.h"

namespace poise::solver {
namespace {

constexpr double kStillMps = 0.1;

MeanChange after(std::initializer_list<double> changes_of_still) {
  MeanChange mean;
  for (const double change : changes_of_still) mean.add(change * kStillMps, kStillMps);
  return mean;
}

TEST(MeanChange, OfBodiesThatCollideSettlesAtAShareOfTheFirst) {
  EXPECT_TRUE(after({3}).collides());
  EXPECT_FALSE(after({3, 1, 0.2}).settled());
  EXPECT_TRUE(after({3, 1, 0.14}).settled());
  EXPECT_FALSE(after({3, 0.14, 0.2}).settled()) << "it grows again";
}

TEST(MeanChange, AtRestDoesNotSettle) {
  EXPECT_FALSE(after({0.9, 1e-6}).settled());
  EXPECT_FALSE(after({0.9, 2}).collides()) << "the first one says it";
  EXPECT_FALSE(after({0}).settled());
}

// Columns of boxes of 1 kg, with a box of `top_kg` on each.
Bench columns(double top_kg) {
  Bench bench;
  bench.settings.gravity_mps2 = Vec3(0, 0, -9.81);
  const auto floor = bench.add_body(0);
  for (int column = 0; column < 20; ++column) {
    auto below = floor;
    for (int i = 0; i < 6; ++i) {
      const double x_m = 3 * column;
      const double z_m = i;
      const auto box = bench.add_body(i < 5 ? 1 : top_kg, Vec3(x_m, 0, z_m + 0.5));
      bench.add_pair(below, box, Vec3(0, 0, 1),
                     {{x_m + 0.4, 0.4, z_m}, {x_m - 0.4, 0.4, z_m}, {x_m - 0.4, -0.4, z_m}, {x_m + 0.4, -0.4, z_m}},
                     0.5);
      below = box;
    }
  }
  return bench;
}
double fastest_mps(const Bench& bench) {
  double fastest = 0;
  for (const SolverBody& body : bench.bodies) fastest = std::max(fastest, body.velocity_mps.norm());
  return fastest;
}

TEST(Rest, ManyColumnsThatCarryATonneEachAreExtrapolated) {
  Bench heavy = columns(1000);
  ASSERT_GT(heavy.points.size(), kFewPoints);
  const Convergence ended = heavy.solve();
  EXPECT_GT(ended.point_iterations, kMixedIterations * 2 * heavy.points.size());
  // As many as plain ones may be.
  Bench plain = columns(1000);
  plain.settings.point_iterations = (kMixedIterations - 1) * static_cast<std::uint32_t>(plain.points.size());
  plain.solve();
  EXPECT_LT(fastest_mps(heavy), 0.8 * fastest_mps(plain));
}

TEST(Rest, OnlyManyBodiesOfLikeMassesThatCollideAreIteratedPlainly) {
  const auto of = [](double top_kg, double speed_mps) {
    Bench bench = columns(top_kg);
    for (std::size_t i = 1; i < bench.bodies.size(); ++i) bench.bodies[i].velocity_mps = Vec3(0, 0, -speed_mps);
    const Convergence ended = bench.solve();
    EXPECT_FALSE(ended.cut_short);
    EXPECT_LT(fastest_mps(bench), std::max(speed_mps / 3, 0.2)) << top_kg << " kg, " << speed_mps << " m/s";
    return ended.point_iterations <= (kMixedIterations - 1) * 2 * bench.points.size();
  };
  EXPECT_TRUE(of(1, 3));
  EXPECT_FALSE(of(1, 0)) << "at rest";
}

TEST(Rest, FewIterationsOfBodiesThatCollideAreNearerToTheEndWhereTheyAreOverRelaxed) {
  const auto falling = [] {
    Bench bench = columns(1);
    for (std::size_t i = 1; i < bench.bodies.size(); ++i) bench.bodies[i].velocity_mps = Vec3(0, 0, -3);
    return bench;
  };
  Bench exact = falling();
  exact.settings.stopping = {1e-6, 100000};
  ASSERT_TRUE(exact.solve().reached);
  const auto error_mps = [&](bool collide, std::uint32_t iterations) {
    Bench bench = falling();
    bench.settings.collide = collide;
    bench.settings.point_iterations = iterations * static_cast<std::uint32_t>(bench.points.size());
    EXPECT_EQ(bench.solve().iterations, 2 * iterations);
    double squares = 0;
    for (std::size_t i = 0; i < bench.bodies.size(); ++i)
      squares += (bench.bodies[i].velocity_mps - exact.bodies[i].velocity_mps).squaredNorm();
    return std::sqrt(squares / static_cast<double>(bench.bodies.size()));
  };
  for (const std::uint32_t iterations : {1U, 2U, 4U})
    EXPECT_LT(error_mps(true, iterations), error_mps(false, iterations)) << iterations;
  EXPECT_NE(error_mps(true, kFewIterations), error_mps(false, kFewIterations));
  EXPECT_EQ(error_mps(true, kFewIterations + 1), error_mps(false, kFewIterations + 1));
}

}  // namespace
}  // namespace poise::solver
