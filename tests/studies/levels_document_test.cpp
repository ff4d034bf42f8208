// SPDX-License-Identifier: MIT
#include "studies/levels_document.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

io::LevelsRow row(std::size_t pair, const char* model, simulation::ProbeLevel level, double dv_mean) {
  io::LevelsRow made;
  made.pair = pair;
  made.model = model;
  made.level = level;
  made.dv = {dv_mean, dv_mean / 2, 2 * dv_mean};
  made.late_share = 0.25;
  made.cost = {400, 200, 50};
  return made;
}

io::LevelsDocument levels_study() {
  io::LevelsDocument d;
  d.half = "report";
  d.touches = 100;
  io::LevelsPair jacks{"jack", "jack", "round", 100};
  jacks.uncertainty = 0.03;
  io::LevelsPair tori{"torus", "torus", "round", 100};
  tori.uncertainty = 0.01;
  d.pairs = {jacks, tori, {"a, \"b\"", "c", "other", 100}};
  d.rows = {row(0, "wrench", {1, false}, 0.40), row(0, "wrench", {2, false}, 0.10),  row(0, "wrench", {2, true}, 0.04),
            row(1, "wrench", {1, false}, 0.30), row(1, "wrench", {2, false}, 0.335), row(1, "wrench", {2, true}, 0.02),
            row(2, "wrench", {1, false}, 0.80)};
  return d;
}

TEST(LevelsDocument, EachRowHasTheMembersOfItsSchema) {
  const json found = json::parse(io::levels_json(levels_study()));
  EXPECT_EQ(found.at("schema"), "poise.levels/2");
  ASSERT_EQ(found.at("rows").size(), 7U);
  const json& first = found.at("rows").at(0);
  for (const char* member :
       {"shape_a", "shape_b", "model", "level", "touches", "dv_mean", "dv_median", "dv_p90", "dw_mean", "dw_median",
        "dw_p90", "toc_ms_mean", "late_share", "ns_per_pair", "oracle_uncertainty"}) {
    EXPECT_TRUE(first.contains(member)) << member;
  }
  EXPECT_EQ(first.at("level"), 1);
  EXPECT_EQ(found.at("rows").at(2).at("level"), "polygons");
  EXPECT_EQ(first.at("ns_per_pair"), 400);
  EXPECT_EQ(first.at("oracle_uncertainty"), 0.03);
  EXPECT_TRUE(found.contains("machine"));
  EXPECT_TRUE(found.contains("build"));
}

TEST(LevelsDocument, SummariesAreMeansOverThePairsOfAGroup) {
  const std::vector<io::LevelsSummary> all = io::summaries(levels_study());
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all[0].pairs, 2U);
  EXPECT_DOUBLE_EQ(all[0].dv.mean, 0.35);
  EXPECT_DOUBLE_EQ(all[0].dv.p90, 0.70);
  EXPECT_DOUBLE_EQ(all[0].late_share, 0.25);
  EXPECT_EQ(all[0].target, 0.45);
  EXPECT_EQ(all[2].target, 0.03) << "polygons";
  EXPECT_EQ(all[3].group, "other");
  EXPECT_FALSE(all[3].target);
}

TEST(LevelsDocument, ASetbackIsWorseByMoreThanTwoPercentAndTheUncertainty) {
  io::LevelsDocument d = levels_study();
  const std::vector<io::LevelsSetback> found = io::setbacks(d);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].row, 4U);
  EXPECT_DOUBLE_EQ(found[0].before, 0.30);
  EXPECT_NE(io::levels_table(d).find("torus torus, wrench, L2: 0.335 after 0.300"), std::string::npos);
  d.pairs[1].uncertainty = 0.02;
  EXPECT_TRUE(io::setbacks(d).empty()) << "and the next pair does not come after this one";
}

TEST(LevelsDocument, TablesHaveALineAPairAndModelAndALineAGroupAndLevel) {
  const std::string text = io::levels_table(levels_study());
  EXPECT_NE(text.find("0.400  0.100     0.040"), std::string::npos) << text;
  EXPECT_NE(text.find("0.45"), std::string::npos);
  EXPECT_NE(text.find("0.12 missed"), std::string::npos) << "the mean of 0.10 and 0.335";
  EXPECT_NE(text.find("2.0 missed"), std::string::npos) << "refinement of 400 ns for overlap tests of 200 ns";
  const auto rows = lines(io::levels_markdown(levels_study()));
  EXPECT_EQ(std::count_if(rows.begin(), rows.end(), [](const std::string& line) { return line.starts_with("| "); }),
            4 + 5 + 3);
  const auto values = lines(io::levels_csv(levels_study()));
  ASSERT_EQ(values.size(), 8U);
  EXPECT_EQ(std::count(values[0].begin(), values[0].end(), ','), std::count(values[1].begin(), values[1].end(), ','));
  EXPECT_TRUE(values[7].starts_with("\"a, \"\"b\"\"\",\"c\",other,wrench,1,100,0.8,"));
}

TEST(LevelsDocument, AChartAGroupALineAModelAndPolygonsRightOfTheDeepestLevel) {
  const std::vector<app::LineChart> charts = io::levels_charts(levels_study());
  ASSERT_EQ(charts.size(), 2U);
  EXPECT_EQ(charts[0].title, "round, 2 pairs of shapes: mean error of dv");
  EXPECT_EQ(charts[0].x_names, (std::vector<std::string>{"0", "1", "2", "polygons"}));
  const auto wrench = std::ranges::find(charts[0].lines, "wrench", &app::ChartLine::label);
  ASSERT_NE(wrench, charts[0].lines.end());
  EXPECT_TRUE(std::ranges::any_of(
      wrench->points, [](const app::LinePoint& point) { return point.x == 2 && std::abs(point.y - 0.2175) < 1e-12; }));
}

}  // namespace
}  // namespace poise::testing
