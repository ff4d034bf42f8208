// SPDX-License-Identifier: MIT
#include "solver/iterations/anderson_mixing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

namespace poise::solver {
namespace {

// One Gauss-Seidel iteration of a chain of springs, which alone takes some hundreds of iterations to converge.
std::vector<double> swept(std::vector<double> x) {
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double left = i > 0 ? x[i - 1] : 0;
    const double right = i + 1 < x.size() ? x[i + 1] : 0;
    x[i] = 0.5 * (left + right + 1);
  }
  return x;
}

int sweeps_until_settled(bool mixed) {
  std::vector<double> x(12, 0.0);
  AndersonMixing mixing;
  mixing.begin(x.size());
  for (int iterations = 1; iterations < 2000; ++iterations) {
    std::vector<double> after = swept(x);
    double change = 0;
    for (std::size_t i = 0; i < x.size(); ++i) change = std::max(change, std::abs(after[i] - x[i]));
    if (change < 1e-9) {
      // The exact solution is a parabola.
      for (std::size_t i = 0; i < x.size(); ++i)
        EXPECT_NEAR(after[i], 0.5 * static_cast<double>((i + 1) * (x.size() - i)), 1e-6);
      return iterations;
    }
    if (mixed) mixing.mix(x, after);
    x = after;
  }
  return 2000;
}

TEST(AndersonMixing, ReachesTheFixedPointOfALinearMapInAboutAsManySweepsAsItHasDirections) {
  EXPECT_GT(sweeps_until_settled(false), 200);
  EXPECT_LT(sweeps_until_settled(true), 40);
}

TEST(AndersonMixing, StartsAnewWhereTheResidualGrows) {
  AndersonMixing mixing;
  mixing.begin(1);
  std::vector<double> after = {1.0};
  EXPECT_FALSE(mixing.mix(std::vector<double>{0.0}, after)) << "one point says nothing yet";
  after = {1.5};
  EXPECT_TRUE(mixing.mix(std::vector<double>{1.0}, after));
  EXPECT_NEAR(after[0], 2.0, 1e-5) << "1, 1/2, 1/4, ...";
  after = {12.0};
  EXPECT_FALSE(mixing.mix(std::vector<double>{2.0}, after));
  EXPECT_EQ(after[0], 12.0);
}

TEST(AndersonMixing, StaysNearWhereStepsHardlyDiffer) {
  // The second number changes at a constant rate whatever happens. Its end is so far away that nothing learned here
  // applies there.
  AndersonMixing mixing;
  mixing.begin(2);
  std::vector<double> after = {1.0, 1e-4};
  mixing.mix(std::vector<double>{0.0, 0.0}, after);
  after = {1.5, 2e-4};
  mixing.mix(std::vector<double>{1.0, 1e-4}, after);
  after = {1.75, 3e-4 - 3e-6};
  EXPECT_TRUE(mixing.mix(std::vector<double>{1.5, 2e-4}, after));
  EXPECT_NEAR(after[0], 2.0, 1e-3);
  EXPECT_NEAR(after[1], 4e-4, 2e-4);
}

}  // namespace
}  // namespace poise::solver
