// SPDX-License-Identifier: MIT
#include "studies/study_draw.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "scene/temporary_folder.h"
#include "studies/study_charts.h"

namespace poise::testing {
namespace {

using app::LineMarks;

std::vector<app::LineChart> some_charts() {
  app::LineChart first{"fall", "error, \"m/s\"", "a note", "budget", {}};
  first.lines.push_back({"one", {{1, 1, 0.5, 1.5}, {10, std::nan(""), {}, {}}, {100, 0.5, {}, {}}}});
  first.lines.push_back({"dots", {{1, 2, {}, {}}}, LineMarks::Dots});
  first.levels.push_back({"deadline", 0.7, std::nullopt});
  first.levels.push_back({"of one", 0.9, 0});
  first.x_log = first.y_log = first.x_measured = true;
  app::LineChart second{"names", "level", "", "scene", {{"line", {{0, 1, {}, {}}, {1, 3, {}, {}}}, LineMarks::Line}}};
  second.y_from_data = true;
  second.x_names = {"heap", "wall"};
  return {first, second};
}

TEST(StudyDraw, TheJsonOfAStudyGivesBackWhatItsPictureShows) {
  const std::vector<app::LineChart> charts = some_charts();
  const std::string json = app::with_charts("{\"schema\": \"poise.x/1\", \"rows\": []}\n", charts, 2);
  const auto document = nlohmann::json::parse(json);
  EXPECT_EQ(document.at("schema"), "poise.x/1");
  EXPECT_TRUE(json.ends_with("}\n"));
  const Result<app::StudyDrawing> drawing = app::drawing_of(json, "x.json");
  ASSERT_TRUE(drawing) << drawing.error().message;
  EXPECT_EQ(drawing.value().columns, 2U);
  EXPECT_EQ(app::charts_plot(drawing.value().charts, 2), app::charts_plot(charts, 2)) << "the same script to the byte";
}

TEST(StudyDraw, AStudyWithoutChartsHasTheJsonThatItHad) {
  EXPECT_EQ(app::with_charts("{\"a\": 1}\n", {}, 1), "{\"a\": 1}\n");
}

TEST(StudyDraw, WhatIsNoDrawingIsRefusedWithTheFileAndTheMember) {
  struct Refusal {
    const char *json, *message;
  };
  const Refusal refusals[] = {
      {"no json", "x.json: has no drawing"},
      {"{\"rows\": []}", "x.json: has no drawing"},
      {R"({"drawing": {"charts": []}})", "x.json: drawing: "},
      {R"({"drawing": {"columns": 1, "charts": []}})", "x.json: drawing.charts has no line, at least one is needed"},
      {R"({"drawing": {"columns": 9, "charts": []}})", "x.json: drawing.columns = 9, must be 1 to 4"},
      {R"({"drawing": {"columns": 1, "charts": [{"id": 7}]}})", "x.json: drawing: "},
  };
  for (const Refusal& refusal : refusals) {
    const Result<app::StudyDrawing> drawing = app::drawing_of(refusal.json, "x.json");
    ASSERT_FALSE(drawing) << refusal.json;
    EXPECT_TRUE(drawing.error().message.starts_with(refusal.message)) << drawing.error().message;
  }
}

TEST(StudyDraw, DrawsAStudyAgainOnBothGrounds) {
  const TemporaryFolder folder;
  const std::string json = folder.file("levels.json");
  std::ofstream(json) << app::with_charts("{\"schema\": \"poise.x/1\"}", some_charts(), 1);
  EXPECT_EQ(poise_command({"study", "draw", json}).exit_code, 2) << "nothing to write";
  const CommandResult same = poise_command({"study", "draw", json, "--svg", json});
  EXPECT_EQ(same.exit_code, 2) << same.error;
  EXPECT_EQ(poise_command({"study", "draw", folder.file("none.json"), "--svg", folder.file("a.svg")}).exit_code, 3);
  const CommandResult drawn = poise_command({"study", "draw", json, "--picture", folder.file("light.png"),
                                             "--picture-dark", folder.file("dark.png"), "--svg", folder.file("a.svg")});
  if (drawn.exit_code == 4 && drawn.error.find("needs gnuplot-nox") != std::string::npos) GTEST_SKIP() << drawn.error;
  ASSERT_EQ(drawn.exit_code, 0) << drawn.error;
  EXPECT_NE(contents(folder.file("light.png")), contents(folder.file("dark.png")));
  const std::string svg = contents(folder.file("a.svg"));
  EXPECT_NE(svg.find("prefers-color-scheme: dark"), std::string::npos);
  EXPECT_NE(svg.find("\"#0072b2\"", svg.find("</style>")), std::string::npos) << "lines that the rules know";
}

}  // namespace
}  // namespace poise::testing
