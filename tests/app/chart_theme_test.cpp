// SPDX-License-Identifier: MIT
#include "app/picture/chart_theme.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "app/report/box_chart.h"
#include "app/report/line_chart.h"

namespace poise::testing {
namespace {

using app::ChartColor;
using app::DarkPart;

// WCAG 2.1: 4.5 is asked of letters, 3 of large ones and of lines.
double contrast(const ChartColor& a, const ChartColor& b) {
  const auto luminance = [](const ChartColor& color) {
    const auto part = [&](std::size_t k) {
      const double share = color[k] / 255.0;
      return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
    };
    return 0.2126 * part(0) + 0.7152 * part(1) + 0.0722 * part(2);
  };
  const double one = luminance(a) + 0.05, other = luminance(b) + 0.05;
  return std::max(one, other) / std::min(one, other);
}

std::string contents_of(const std::string& file) {
  std::ifstream in(std::string(POISE_SOURCE_DIR) + "/" + file);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(ChartTheme, LettersAndLinesAreReadableOnBothGrounds) {
  const ChartColor dark_ground = app::dark_color(app::kChartGround, DarkPart::Frame);
  EXPECT_GE(contrast(app::kChartInk, app::kChartGround), 7);
  EXPECT_GE(contrast(app::dark_color(app::kChartInk, DarkPart::Frame), dark_ground), 7);
  for (const ChartColor& line : app::kChartLines) {
    EXPECT_GE(contrast(line, app::kChartGround), 3) << app::color_text(line);
    EXPECT_GE(contrast(app::dark_color(line, DarkPart::All), dark_ground), 4.5) << app::color_text(line);
  }
}

TEST(ChartTheme, EveryLineHasItsOwnColourOnBothGrounds) {
  std::vector<ChartColor> light(app::kChartLines.begin(), app::kChartLines.end()), dark;
  for (const ChartColor& line : light) dark.push_back(app::dark_color(line, DarkPart::All));
  for (std::vector<ChartColor>* colors : {&light, &dark}) {
    std::ranges::sort(*colors);
    EXPECT_EQ(std::ranges::adjacent_find(*colors), colors->end());
  }
}

TEST(ChartTheme, AScriptBecomesDarkAndWhatIsInNoChartStays) {
  EXPECT_EQ(app::dark_text("lc rgb \"#0072b2\" bg \"#ffffff\" # a comment, \"#fde725\" and #"),
            "lc rgb \"#5aa9e0\" bg \"#14191f\" # a comment, \"#fde725\" and #");
}

TEST(ChartTheme, AnSvgHasRulesForBrowsersThatPreferDark) {
  const std::string svg = app::svg_with_dark("<?xml?><svg width=\"9\"\n>x</svg>", DarkPart::All);
  EXPECT_TRUE(svg.starts_with("<?xml?><svg width=\"9\"\n>\n<style>@media (prefers-color-scheme: dark) {")) << svg;
  EXPECT_NE(svg.find("[stroke=\"#0072b2\"] { stroke: #5aa9e0 }"), std::string::npos);
  const std::string frame = app::svg_with_dark("<svg></svg>", DarkPart::Frame);
  EXPECT_NE(frame.find("[fill=\"#ffffff\"] { fill: #14191f }"), std::string::npos);
  EXPECT_EQ(frame.find("#0072b2"), std::string::npos) << "areas keep their colours";
}

TEST(ChartTheme, ChartsAreDrawnInColoursThatTheRulesKnow) {
  const std::string line = app::line_chart_svg({"id", "title", "", "x", {{"one", {{0, 1, 0.5, 1.5}, {1, 2, 1, 3}}}}});
  app::BoxChart boxes = app::plot::begin("title", "ms", "frame");
  app::plot::tick_up(boxes, 0.5, "1");
  for (const std::string& svg : {line, app::chart_svg(boxes)}) {
    EXPECT_NE(svg.find("prefers-color-scheme: dark"), std::string::npos);
    for (const ChartColor& color : {app::kChartGround, app::kChartInk, app::kChartGrid}) {
      const std::string drawn = "=\"" + app::color_text(color) + '"';
      const bool in_rules_alone =
          svg.find(drawn, svg.find("</style>")) == std::string::npos && svg.find(drawn) > svg.find("<style>");
      EXPECT_FALSE(in_rules_alone) << drawn;
    }
    EXPECT_EQ(svg.find("=\"white\""), std::string::npos);
    EXPECT_EQ(svg.find("=\"#ddd\""), std::string::npos);
  }
}

// The pages are written in another language, and must look like the files beside them.
TEST(ChartTheme, ThePagesHaveTheSameColours) {
  const std::string style = contents_of("viewer/src/figures/style.css");
  const std::size_t dark = style.find("[data-theme=\"dark\"]");
  ASSERT_NE(dark, std::string::npos);
  for (std::size_t i = 0; i < app::kChartLines.size(); ++i) {
    const ChartColor& line = app::kChartLines[i];
    const std::string light_rule = fmt::format("--line-{}: {};", i, app::color_text(line));
    const std::string dark_rule =
        fmt::format("--line-{}: {};", i, app::color_text(app::dark_color(line, DarkPart::All)));
    EXPECT_LT(style.find(light_rule), dark) << light_rule;
    EXPECT_NE(style.find(dark_rule, dark), std::string::npos) << dark_rule;
  }
  const std::string palette = contents_of("viewer/src/palette.js");
  for (const ChartColor& stage : app::kStageColors)
    EXPECT_NE(palette.find('"' + app::color_text(stage) + '"'), std::string::npos) << app::color_text(stage);
  EXPECT_NE(contents_of("viewer/src/style.css").find("--late: " + app::color_text(app::kChartLate)), std::string::npos);
}

}  // namespace
}  // namespace poise::testing
