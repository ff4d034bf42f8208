// SPDX-License-Identifier: MIT
#include "studies/study_charts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace poise::testing {
namespace {

app::LineChart some_chart() {
  app::LineChart chart{"id",
                       "a \"title\"",
                       "",
                       "bodies",
                       {{"one", {{100, 1e-7, {}, {}}, {200, std::nan(""), {}, {}}, {400, 1e-3, 1e-4, 1e-2}}}}};
  chart.lines.push_back({"dots", {{100, 1e-5, {}, {}}}, app::LineMarks::Dots});
  chart.levels = {{"allowed", 1e-2, 0}};
  chart.x_log = chart.y_log = true;
  return chart;
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(StudyCharts, TheScriptHasAPanelForEachWithNamesBesideTheLines) {
  const std::string script = app::charts_plot({some_chart(), some_chart(), some_chart()}, 2);
  EXPECT_NE(script.find("size 1400,880"), std::string::npos) << "two rows of two";
  EXPECT_EQ(count_of(script, "\nplot "), 3U);
  EXPECT_EQ(count_of(script, "unset key"), 3U);
  EXPECT_EQ(count_of(script, "\"one\" at graph 1,"), 3U);
  EXPECT_EQ(count_of(script, "\"allowed\" at graph 1,"), 3U);
  EXPECT_NE(script.find("set title \"a 'title'\" noenhanced"), std::string::npos);
  EXPECT_NE(script.find("\n200 NaN NaN NaN\n"), std::string::npos) << "a gap";
  EXPECT_NE(script.find("\n400 0.001 0.0001 0.01\n"), std::string::npos) << "an interval";
  EXPECT_NE(script.find("$line1 using 1:2 with points"), std::string::npos);
  EXPECT_NE(script.find("\"10^{-6}\" 1e-06"), std::string::npos);
  EXPECT_EQ(app::charts_plot({}, 2), "");
}

TEST(StudyCharts, WhatHasNoValueIsLeftOutAndLevelsStayWithTheirLines) {
  app::LineChart chart{"id", "t", "", "x", {{"empty", {}}, {"full", {{0, 1, {}, {}}}}}};
  chart.levels = {{"of empty", 1, 0}, {"of full", 2, 1}, {"own", 3, {}}};
  std::vector<app::LineChart> charts{chart, {"none", "t", "", "x", {{"gaps", {{0, std::nan(""), {}, {}}}}}}};
  app::leave_out_empty(charts);
  ASSERT_EQ(charts.size(), 1U);
  ASSERT_EQ(charts[0].lines.size(), 1U);
  ASSERT_EQ(charts[0].levels.size(), 2U);
  EXPECT_EQ(charts[0].levels[0].label, "of full");
  EXPECT_EQ(charts[0].levels[0].line, 0U);
}

TEST(StudyCharts, ManyNamesBecomeNumbers) {
  app::LineChart chart;
  app::name_places(chart, {"a", "b"}, "cases");
  EXPECT_EQ(chart.x_names, (std::vector<std::string>{"a", "b"}));
  app::name_places(chart, std::vector<std::string>(30, "case"), "cases");
  EXPECT_EQ(chart.x_names[29], "30");
  EXPECT_EQ(chart.x_label, "cases, by number, in the order of the table");
}

}  // namespace
}  // namespace poise::testing
