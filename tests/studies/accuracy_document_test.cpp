// SPDX-License-Identifier: MIT
#include "studies/accuracy_document.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace poise::testing {
namespace {

using nlohmann::json;

io::AccuracyDocument study() {
  io::AccuracyDocument d;
  d.rows = {{"slope", "angle", "degree", 26.57, {}, "", true},
            {"slope", "error of the angle", "degree", 0.4, 0.1, "", false},
            {"666", "penetration", "m^2", 0.0001, 0.0153, "RaiSim 0.0153", true},
            {"666", "bodies lost", "", std::nan(""), 0, "", false}};
  d.series = {{"stack", {0.25, 0.5}, {0, 1e-3}, {2, 0}}};
  d.threads = 1;
  d.build.commit = "abc";
  return d;
}

TEST(AccuracyDocument, JsonHasARowForEachFigureAndSaysWhatItIs) {
  const json found = json::parse(io::accuracy_json(study()));
  EXPECT_EQ(found.at("schema"), "poise.accuracy/1");
  ASSERT_EQ(found.at("rows").size(), 4U);
  const json expected = {{"case", "666"},     {"figure", "penetration"},      {"unit", "m^2"}, {"value", 0.0001},
                         {"at_most", 0.0153}, {"published", "RaiSim 0.0153"}, {"ok", true}};
  EXPECT_EQ(found.at("rows").at(2), expected);
  EXPECT_EQ(found.at("rows").at(0).at("at_most"), nullptr);
  EXPECT_EQ(found.at("rows").at(0).at("published"), nullptr);
  EXPECT_EQ(found.at("rows").at(3).at("value"), nullptr) << "JSON has no NaN";
  EXPECT_EQ(found.at("missed"), 2);
  EXPECT_EQ(found.at("series").at(0).at("drift_m"), (json{0.0, 1e-3}));
  EXPECT_EQ(found.at("build").at("commit"), "abc");
  EXPECT_TRUE(found.at("machine").contains("processor"));
}

TEST(AccuracyDocument, TablesTellWhatWasMissedAndNameACaseOnce) {
  const std::string table = io::accuracy_table(study());
  const std::string markdown = io::accuracy_markdown(study());
  EXPECT_NE(markdown.find("| slope | angle | degree | 26.57 | - |  | - |\n|  | error of the angle | degree | 0.4 | 0.1 "
                          "|  | missed |\n"),
            std::string::npos)
      << markdown;
  EXPECT_NE(markdown.find("| 666 | penetration | m^2 | 0.0001 | 0.0153 | RaiSim 0.0153 | ok |"), std::string::npos)
      << markdown;
  for (const std::string& text : {table, markdown}) {
    EXPECT_NE(text.find("2 of 4 rows missed"), std::string::npos) << text;
    EXPECT_EQ(text.find("slope"), text.rfind("slope"));
  }
}

TEST(AccuracyDocument, HasBothChartsAndNoLogarithmOfNought) {
  const std::vector<app::LineChart> charts = io::accuracy_charts(study());
  ASSERT_EQ(charts.size(), 2U);
  const std::vector<app::LinePoint>& drift = charts[0].lines[0].points;
  const std::vector<app::LinePoint>& energy = charts[1].lines[0].points;
  EXPECT_TRUE(std::isnan(drift[0].y)) << "a gap";
  EXPECT_EQ(drift[1].y, 0.001);
  EXPECT_EQ(energy[0].y, 2);
  EXPECT_TRUE(std::isnan(energy[1].y));
  io::AccuracyDocument none = study();
  none.series.clear();
  EXPECT_TRUE(io::accuracy_charts(none)[0].lines.empty());
}

TEST(AccuracyDocument, OfEachCaseTheFigureNearestToItsBoundIsDrawn) {
  const app::LineChart chart = io::bounds_chart(study());
  ASSERT_EQ(chart.x_names, (std::vector<std::string>{"slope", "666"}));
  ASSERT_EQ(chart.lines.size(), 1U);
  EXPECT_DOUBLE_EQ(chart.lines[0].points[0].y, 4) << "0.4 where 0.1 is allowed";
  ASSERT_EQ(chart.levels.size(), 1U);
  EXPECT_EQ(chart.levels[0].y, 1);
}

}  // namespace
}  // namespace poise::testing
