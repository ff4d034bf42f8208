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

TEST(AccuracyDocument, ThePlotHasBothPanelsAndNoLogarithmOfNought) {
  const std::string plot = io::accuracy_plot(study());
  EXPECT_NE(plot.find("0.25 NaN 2\n0.5 0.001 NaN\n"), std::string::npos) << plot;
  EXPECT_NE(plot.find("$case0 using 1:2"), std::string::npos);
  EXPECT_NE(plot.find("$case0 using 1:3"), std::string::npos);
  io::AccuracyDocument none = study();
  none.series.clear();
  EXPECT_EQ(io::accuracy_plot(none), "");
}

}  // namespace
}  // namespace poise::testing
