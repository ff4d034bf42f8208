// SPDX-License-Identifier: MIT
#include "app/report/figures_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/command.h"
#include "app/compare/compare_report.h"
#include "app/pages.h"
#include "app/report/report_template.h"
#include "scene/temporary_folder.h"

namespace poise::testing {
namespace {

using nlohmann::json;

bool figures_are_built() { return app::read_report_template(app::figures_template_places()).ok(); }

json figures_in(const std::string& page) { return json::parse(embedded(page, "poise-figures"), nullptr, false); }

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

app::FiguresDocument document_of(const app::LineChart& chart) {
  app::FiguresDocument document;
  document.charts = {chart};
  return document;
}

app::LineChart falling() {
  return {"fall",
          "<b> & more",
          "a note",
          "budget",
          {{"one", {{0, 1, 0.5, 1.5}, {10, 0.5, 0.25, 0.75}}}, {"two", {{0, 1, {}, {}}, {10, 0.51, {}, {}}}}}};
}

TEST(LineChart, HasALineForEachAndABandWhereThereAreIntervals) {
  const std::string svg = app::line_chart_svg(falling());
  EXPECT_TRUE(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
  EXPECT_EQ(count_of(svg, "<polyline"), 2U);
  EXPECT_EQ(count_of(svg, "<polygon"), 1U);
  app::LineChart turned = falling();
  std::swap(turned.lines[0], turned.lines[1]);
  const std::string bands_below = app::line_chart_svg(turned);
  EXPECT_LT(bands_below.rfind("<polygon"), bands_below.find("<polyline")) << "no band lies over a line";
  EXPECT_EQ(count_of(svg, "<circle"), 4U);
  EXPECT_NE(svg.find("&lt;b> &amp; more"), std::string::npos);
  EXPECT_TRUE(app::line_chart_svg({}).ends_with("</svg>\n")) << "of nothing";
}

TEST(LineChart, TheImageHasTheColoursOfItsLines) {
  const io::Image image = app::line_chart_image(falling());
  ASSERT_EQ(image.rgb.size(), std::size_t{3} * image.width_px * image.height_px);
  const auto pixels = [&](std::array<int, 3> color) {
    std::size_t count = 0;
    for (std::size_t at = 0; at < image.rgb.size(); at += 3)
      count += std::equal(color.begin(), color.end(), image.rgb.begin() + static_cast<std::ptrdiff_t>(at)) ? 1U : 0U;
    return count;
  };
  EXPECT_GT(pixels({0x00, 0x72, 0xb2}), 100U);
  EXPECT_GT(pixels({0xd5, 0x5e, 0x00}), 100U);
  EXPECT_EQ(pixels({0x00, 0x9e, 0x73}), 0U) << "there is no third line";
}

TEST(LineChart, NamesOfLinesThatEndTogetherDoNotLieOverEachOther) {
  const std::string svg = app::line_chart_svg(falling());
  const auto height_of = [&](const std::string& name) {
    const std::size_t end = svg.find(">" + name + "</text>");
    const std::size_t y = svg.rfind("y=\"", end) + 3;
    return std::stod(svg.substr(y));
  };
  EXPECT_GE(std::abs(height_of("one") - height_of("two")), 15);
}

TEST(LineChart, GapsEndALineAndLevelsAreDashed) {
  app::LineChart chart{
      "id", "t", "", "x", {{"l", {{1, 1, {}, {}}, {2, std::nan(""), {}, {}}, {3, 2, {}, {}}, {4, 5, {}, {}}}}}};
  chart.levels = {{"deadline", 3, {}}};
  EXPECT_EQ(count_of(app::line_chart_svg(chart), "<polyline"), 2U);
  EXPECT_EQ(count_of(app::line_chart_svg(chart), "stroke-dasharray"), 1U);
  EXPECT_EQ(count_of(app::line_chart_svg(chart), ">deadline</text>"), 1U);
  const json of_page = figures_in(app::figures_page("<!-- poise:data -->", document_of(chart))).at("charts")[0];
  EXPECT_EQ(of_page.at("lines")[0].at("points")[1], json::parse("[2.0,null]"));
  EXPECT_EQ(of_page.at("levels")[0].at("y"), 3);
  EXPECT_LT(of_page.at("y").at("least"), 0) << "so that a line at 0 is seen";
  chart.lines[0].marks = app::LineMarks::Dots;
  EXPECT_EQ(count_of(app::line_chart_svg(chart), "<polyline"), 0U);
  chart.lines[0].marks = app::LineMarks::Line;
  EXPECT_EQ(count_of(app::line_chart_svg(chart), "<circle"), 0U);
}

TEST(FiguresPage, HoldsTheDocumentAndNoMarkupOfIt) {
  app::FiguresDocument document;
  document.title = "</script><b>";
  document.mark = app::FiguresDocument::Mark::Bad;
  document.charts = {falling()};
  document.pictures = {{"drawn", "image/png", "foo"}};
  document.settings = {{"seed", "7"}};
  document.command = {"poise", "compare", "a b"};
  const std::string page = app::figures_page("before <!-- poise:data --> after $&", document);
  EXPECT_TRUE(page.starts_with("before ") && page.ends_with(" after $&"));
  EXPECT_EQ(count_of(page, "</script>"), 1U);
  const json figures = figures_in(page);
  EXPECT_EQ(figures.at("title"), "</script><b>");
  EXPECT_EQ(figures.at("headline").at("mark"), "bad");
  EXPECT_EQ(figures.at("charts")[0].at("lines")[0].at("points"),
            json::parse("[[0.0,1.0,0.5,1.5],[10.0,0.5,0.25,0.75]]"));
  EXPECT_EQ(figures.at("charts")[0].at("lines")[1].at("points")[0].size(), 2U) << "without an interval";
  EXPECT_EQ(figures.at("pictures")[0].at("base64"), "Zm9v");
  EXPECT_EQ(figures.at("settings").at("seed"), "7");
  EXPECT_EQ(figures.at("command"), "poise compare 'a b'");
}

TEST(FiguresPage, LiesBesideThePageOfARun) {
  const auto runs = app::report_template_places();
  const auto figures = app::figures_template_places();
  ASSERT_EQ(figures.size(), runs.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    EXPECT_EQ(figures[i].parent_path(), runs[i].parent_path());
    EXPECT_EQ(figures[i].filename(), "figures.html");
  }
}

TEST(CompareReport, IsWrittenWholeOrRefusedBeforeTheWork) {
  const TemporaryFolder folder;
  const std::string out = folder.file("made/here");
  const CommandResult result =
      poise_command({"compare", "jacks", "--bodies", "30", "--frames", "2", "--every", "10", "--warmup", "30",
                     "--policies", "perceptual,fifo,oracle", "--budgets", "0%,50%", "--quiet", "--report", out});
  if (!figures_are_built()) return expect_no_page(result, out);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(files_in(out), (std::vector<std::string>{"e-rel.png", "e-rel.svg", "e-seen.png", "e-seen.svg", "e.png",
                                                     "e.svg", "regret.png", "regret.svg", "report.html"}));
  const json figures = figures_in(contents(out + "/report.html"));
  EXPECT_EQ(figures.at("title"), "jacks: policies compared");
  EXPECT_NE(figures.at("headline").at("text").get<std::string>().find("mean E_seen"), std::string::npos);
  ASSERT_EQ(figures.at("charts").size(), 4U);
  for (const json& point : figures.at("charts")[1].at("lines")[0].at("points")) {
    EXPECT_LE(point[2], point[1]);
    EXPECT_GE(point[3], point[1]);
  }
  EXPECT_EQ(figures.at("charts")[3].at("lines").size(), 2U) << "regret is measured from the oracle";
  EXPECT_EQ(count_of(figures.at("tables").get<std::string>(), "\n| perceptual |"), 3U);
}

io::ComparisonDocument compared(std::size_t frames) {
  io::ComparisonDocument document;
  io::ComparedSteps steps{{"perceptual", "random"}, {0, 10}, {}};
  for (std::size_t frame = 0; frame < frames; ++frame) {
    for (const double e_mps : {2.0, 1.0, 4.0, 3.0}) {
      io::ComparedStep step;
      step.converged = true;
      step.e_mps = step.e_rel = step.e_seen_mps = e_mps + static_cast<double>(frame);
      steps.steps.push_back(step);
    }
  }
  document.result = io::compare_steps(steps, 1);
  return document;
}

TEST(CompareReport, IsNotSureOfFewStatesAndDrawsNoBandOfOne) {
  const app::FiguresDocument sure = app::comparison_figures(compared(6), {});
  EXPECT_EQ(sure.mark, app::FiguresDocument::Mark::Good);
  EXPECT_EQ(sure.headline, "perceptual leaves the least to be seen");
  const app::FiguresDocument few = app::comparison_figures(compared(5), {});
  EXPECT_EQ(few.mark, app::FiguresDocument::Mark::None);
  EXPECT_EQ(few.headline, "Too few states to tell perceptual from random");
  EXPECT_TRUE(few.charts[0].lines[0].points[0].low);
  const app::FiguresDocument one = app::comparison_figures(compared(1), {});
  EXPECT_FALSE(one.charts[0].lines[0].points[0].low);
  EXPECT_EQ(one.charts[0].note, "Lower is better.");
  EXPECT_NE(one.tables.find("| perceptual | 0 | 2 | - |"), std::string::npos) << one.tables;
}

TEST(CompareReport, IsRefusedWhereItCannotBeWritten) {
  if (!figures_are_built()) GTEST_SKIP() << "the page is not built: cmake/build_viewer.sh";
  const TemporaryFolder folder;
  std::ofstream(folder.file("file")) << "x";
  const CommandResult result =
      poise_command({"compare", "jacks", "--bodies", "30", "--frames", "1", "--report", folder.file("file/r")});
  EXPECT_EQ(result.exit_code, 4) << result.error;
  EXPECT_EQ(result.error.find("poise compare: "), 0U) << result.error;
}

}  // namespace
}  // namespace poise::testing
