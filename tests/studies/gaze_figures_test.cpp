// SPDX-License-Identifier: MIT
#include "studies/gaze_figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

// All states and jumps are invented.
namespace poise::app {
namespace {

/// A body near the gaze point `near` and far from the others.
GazeBody body_near(std::size_t near, double own_eps2, double other_eps2) {
  GazeBody body;
  body.cell = static_cast<std::uint32_t>(near);
  body.eccentricity_rad.fill(30 * kGazeDegreeRad);
  body.eps2.fill(other_eps2);
  body.eccentricity_rad[near] = 1 * kGazeDegreeRad;
  body.eps2[near] = own_eps2;
  body.full_eps2 = 0.25;
  return body;
}

GazeState state_of(std::vector<GazeBody> bodies) {
  GazeState state;
  state.bodies = std::move(bodies);
  return state;
}

TEST(GazeBins, EndWhereTheTableSays) {
  EXPECT_EQ(bin_of(0), 0U);
  EXPECT_EQ(bin_of(1.99 * kGazeDegreeRad), 0U);
  EXPECT_EQ(bin_of(2.01 * kGazeDegreeRad), 1U);
  EXPECT_EQ(bin_of(9 * kGazeDegreeRad), 2U);
  EXPECT_EQ(bin_of(19 * kGazeDegreeRad), 3U);
  EXPECT_EQ(bin_of(21 * kGazeDegreeRad), 4U);
  EXPECT_EQ(bin_of(std::numbers::pi), 4U);
}

TEST(GazeBins, HaveTheRootMeanSquareOfTheirBodiesAndTheLevelsOfTheirPairs) {
  GazeState state = state_of({body_near(0, 1, 16), body_near(0, 7, 16)});
  state.levels[0][0] = {3, 2, 1, 4};
  const std::vector<GazeBinRow> rows = gaze_bins(std::vector{state, state});
  ASSERT_EQ(rows.size(), kGazePoints * kEccentricityBins);
  EXPECT_EQ(rows[0].bodies, 4U);
  EXPECT_EQ(rows[0].e_mps, 2) << "root of the mean of 1 and 7";
  EXPECT_EQ(rows[0].elsewhere_mps, 4);
  EXPECT_EQ(rows[0].full_e_mps, 0.5);
  EXPECT_EQ(rows[0].levels.level_mean(), 1.5);
  EXPECT_EQ(rows[0].levels.answered_share(), 0.25);
  EXPECT_EQ(rows[1].bodies, 0U);
  EXPECT_FALSE(rows[1].e_mps);
  EXPECT_FALSE(rows[1].levels.level_mean());
  const GazeBinRow& other = rows[kEccentricityBins + 4];
  EXPECT_EQ(other.gaze_point, 1U);
  EXPECT_EQ(other.e_mps, 4) << "the same bodies are far from the other points";
}

TEST(NearRatio, IsTheErrorNearTheGazeOverThatOfTheSameBodiesWithTheGazeElsewhere) {
  const std::vector<GazeState> states(3, state_of({body_near(0, 1, 4), body_near(1, 4, 4), body_near(2, 9, 36)}));
  const std::vector<NearRatio> ratios = near_ratios(states, 1);
  ASSERT_EQ(ratios.size(), 4U);
  EXPECT_EQ(ratios[0].bodies, 3U);
  EXPECT_EQ(ratios[0].ratio, 0.5);
  EXPECT_EQ(ratios[1].ratio, 1);
  EXPECT_EQ(ratios[2].e_mps, 3);
  EXPECT_EQ(ratios[2].elsewhere_mps, 6);
  EXPECT_EQ(ratios[3].bodies, 9U);
  EXPECT_NEAR(*ratios[3].ratio, std::sqrt(14.0 / 44.0), 1e-12) << "of the sums";
  EXPECT_FALSE(ratios[3].gaze_point);
  EXPECT_EQ(ratios[0].low, 0.5) << "states that are alike leave no doubt";
  EXPECT_EQ(ratios[0].high, 0.5);
}

TEST(NearRatio, HasAnIntervalThatGrowsWithTheDifferencesOfStates) {
  std::vector<GazeState> states;
  for (int i = 0; i < 8; ++i) states.push_back(state_of({body_near(0, i % 2 == 0 ? 1 : 4, 4)}));
  const NearRatio ratio = near_ratios(states, 1)[0];
  EXPECT_NEAR(*ratio.ratio, std::sqrt(2.5 / 4), 1e-12);
  EXPECT_LT(ratio.low, *ratio.ratio - 0.05);
  EXPECT_GT(ratio.high, *ratio.ratio + 0.05);
  EXPECT_GE(ratio.low, 0.5);
  EXPECT_LE(ratio.high, 1);
}

TEST(NearRatio, IsEmptyWhereNothingIsWrongElsewhere) {
  EXPECT_FALSE(near_ratios(std::vector{state_of({body_near(0, 0, 0)})}, 1)[0].ratio);
  EXPECT_FALSE(near_ratios({}, 1)[0].ratio);
  EXPECT_FALSE(near_ratios({}, 1)[0].e_mps);
}

TEST(GazeCells, AreEmptyWhereFewBodiesHaveBeen) {
  const std::vector<GazeState> states(kLeastInCell, state_of({body_near(2, 9, 4)}));
  const auto cells = gaze_cells(states, 2);
  ASSERT_EQ(cells.size(), kCellsAcross * kCellsDown);
  EXPECT_EQ(cells[2], 3);
  EXPECT_EQ(gaze_cells(states, 0)[2], 2);
  EXPECT_FALSE(cells[3]);
  EXPECT_FALSE(gaze_cells(std::span(states).first(kLeastInCell - 1), 2)[2]);
}

/// `before` frames of 1, then `after`, then 2, as many frames from the jump on as before.
std::vector<double> rise(std::size_t half, std::vector<double> after) {
  std::vector<double> values(2 * half, 1);
  for (std::size_t i = half; i < 2 * half; ++i) values[i] = i - half < after.size() ? after[i - half] : 2;
  return values;
}

TEST(ServedFrame, IsTheFirstThatIsNineTenthsOfTheWay) {
  EXPECT_EQ(served_frame(rise(30, {})), 0U) << "in the first frame with the new gaze";
  EXPECT_EQ(served_frame(rise(30, {1, 1.5, 1.89, 1.91})), 3U);
  EXPECT_EQ(served_frame(rise(30, {1, 1.95, 1.5})), 1U) << "the first one, even where the next falls behind again";
  EXPECT_EQ(served_frame(rise(30, {1, 1, 1, 1, 1, 1})), 6U);
}

TEST(ServedFrame, TakesTheLevelBeforeFromTheTenFramesBeforeTheJump) {
  std::vector<double> values = rise(30, {1.85});
  EXPECT_EQ(served_frame(values), 1U);
  for (std::size_t i = 0; i < 20; ++i) values[i] = 0;
  EXPECT_EQ(served_frame(values), 1U) << "frames long before do not count";
  for (std::size_t i = 20; i < 30; ++i) values[i] = 0;
  EXPECT_EQ(served_frame(values), 0U) << "90 % of the way from 0 is 1.8";
}

TEST(ServedFrame, IsEmptyWithoutARise) {
  EXPECT_FALSE(served_frame(std::vector<double>(60, 1.0)));
  std::vector<double> falls(60, 1.0);
  falls[45] = 0.5;
  EXPECT_FALSE(served_frame(falls));
}

/// A jump near whose new point so many of a hundred pairs are answered.
GazeJump jump_of(const std::vector<double>& shares) {
  GazeJump jump;
  for (const double share : shares) jump.at_new.push_back({0, 0, static_cast<std::uint64_t>(100 * share), 100});
  jump.at_old.resize(shares.size());
  return jump;
}

TEST(ServedFigures, CountJumpsByThemselvesAndTheMeanOfThem) {
  std::vector<double> slow = rise(20, {1, 1, 1, 1, 1});
  std::vector<double> fast = rise(20, {});
  std::vector<double> none(40, 1.0);
  for (auto* values : {&slow, &fast, &none}) {
    for (double& value : *values) value *= 0.4;
  }
  const std::vector<GazeJump> jumps{jump_of(slow), jump_of(fast), jump_of(fast), jump_of(none)};
  const ServedFigures figures = served_figures(jumps, &PairLevels::answered_share);
  EXPECT_EQ(figures.jumps, 3U);
  EXPECT_EQ(figures.without_rise, 1U);
  EXPECT_EQ(figures.median, 0);
  EXPECT_EQ(figures.largest, 5);
  EXPECT_EQ(figures.within_three, 2U);
  EXPECT_EQ(figures.of_mean, 5U);
  EXPECT_NEAR(figures.before, 0.4, 1e-12);
  EXPECT_NEAR(figures.settled, 0.7, 1e-12);
  const ServedFigures levels = served_figures(jumps, &PairLevels::level_mean);
  EXPECT_EQ(levels.jumps, 0U) << "there are no contacts";
  EXPECT_FALSE(levels.median);
}

}  // namespace
}  // namespace poise::app
