// SPDX-License-Identifier: MIT
#include "app/report/chart_axes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace poise::testing {
namespace {

using app::LineChart;

LineChart with_values(const std::vector<double>& values) {
  LineChart chart{"id", "t", "", "x", {{"line", {}}}};
  for (std::size_t i = 0; i < values.size(); ++i)
    chart.lines[0].points.push_back({static_cast<double>(i + 1), values[i], {}, {}});
  return chart;
}

std::vector<std::string> texts(const app::ChartAxis& axis) {
  std::vector<std::string> found;
  for (const app::ChartTick& tick : axis.ticks) found.push_back(tick.text);
  return found;
}

TEST(ChartAxes, NoValueLiesOnAnEdge) {
  for (const std::vector<double>& values :
       {std::vector<double>{0, 0, 0}, {0, 1}, {5, 5}, {-3, 2}, {1e-9, 3e7}, {0.988, 1.002}}) {
    for (const bool log : {false, true}) {
      for (const bool from_data : {false, true}) {
        LineChart chart = with_values(values);
        chart.y_log = log;
        chart.y_from_data = from_data;
        const app::ChartAxis axis = app::y_axis_of(chart);
        ASSERT_GT(axis.most, axis.least);
        for (const double value : values) {
          if (!axis.shows(value)) continue;
          EXPECT_GT(axis.share(value), 0.02) << value;
          EXPECT_LT(axis.share(value), 0.98) << value;
        }
        EXPECT_GE(axis.ticks.size(), 2U);
        for (const app::ChartTick& tick : axis.ticks) EXPECT_NEAR(axis.share(tick.at), 0.5, 0.51) << tick.text;
      }
    }
  }
}

TEST(ChartAxes, TicksAreRoundAndShort) {
  EXPECT_EQ(texts(app::y_axis_of(with_values({0, 1}))),
            (std::vector<std::string>{"0", "0.2", "0.4", "0.6", "0.8", "1"}));
  EXPECT_EQ(texts(app::y_axis_of(with_values({0, 50'000}))),
            (std::vector<std::string>{"0", "10,000", "20,000", "30,000", "40,000", "50,000"}));
  LineChart chart = with_values({1e-7, 1e-1});
  chart.y_log = true;
  EXPECT_EQ(texts(app::y_axis_of(chart)),
            (std::vector<std::string>{"1e-7", "1e-6", "1e-5", "0.0001", "0.001", "0.01", "0.1"}));
  chart = with_values({3, 40});
  chart.y_log = true;
  EXPECT_EQ(texts(app::y_axis_of(chart)), (std::vector<std::string>{"5", "10", "20"}));
}

TEST(ChartAxes, PlacesThatWereChosenHaveTheTicks) {
  LineChart chart = with_values({1, 2, 3});
  for (app::LinePoint& point : chart.lines[0].points) point.x = std::sqrt(2) * std::pow(10, point.x);
  chart.x_log = true;
  EXPECT_EQ(texts(app::x_axis_of(chart)), (std::vector<std::string>{"14.1", "141", "1410"}));
  chart.lines[0].marks = app::LineMarks::Dots;
  EXPECT_EQ(texts(app::x_axis_of(chart)).front(), "20") << "where a measurement has put them, round ones";
  chart.x_names = {"a", "b"};
  EXPECT_EQ(texts(app::x_axis_of(chart)), (std::vector<std::string>{"a", "b"}));
}

TEST(ChartAxes, NamesOfLinesAndLevelsKeepALinesDistance) {
  LineChart chart = with_values({1, 1});
  chart.lines.push_back(chart.lines[0]);
  chart.levels = {{"level", 1, {}}};
  const std::vector<app::ChartName> names = app::names_of(chart, app::y_axis_of(chart), 0.1);
  ASSERT_EQ(names.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < i; ++k) EXPECT_GE(std::abs(names[i].at - names[k].at), 0.1 - 1e-12);
    EXPECT_LE(names[i].at, 1);
  }
}

TEST(ChartAxes, LongNamesStandInSeveralRows) {
  app::ChartAxis axis{-0.4, 3.6, false, {{0, "ab"}, {1, "cd"}, {2, "ef"}, {3, "gh"}}};
  EXPECT_EQ(app::tick_rows(axis, 0.01), 1U);
  for (app::ChartTick& tick : axis.ticks) tick.text = std::string(30, 'x');
  EXPECT_EQ(app::tick_rows(axis, 0.01), 2U);
}

}  // namespace
}  // namespace poise::testing
