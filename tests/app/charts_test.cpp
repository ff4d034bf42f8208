// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "app/report/frame_chart.h"

namespace poise::testing {
namespace {

simulation::RunFrame frame_of(double total_ms, MissCause cause = MissCause::None) {
  simulation::RunFrame frame;
  const auto time = Nanoseconds(static_cast<std::int64_t>(total_ms * 1e6));
  frame.report.times.solve = time;
  frame.report.times.total = time;
  frame.report.cause = cause;
  return frame;
}

TEST(FrameChart, StacksTimesToTheirScaleAndMarksLateFrames) {
  const std::vector<simulation::RunFrame> frames{frame_of(4), frame_of(8, MissCause::Forecast), frame_of(2)};
  const app::BoxChart chart = app::frame_chart("<heap>", 5.0, frames);
  constexpr std::array<std::uint8_t, 3> kSolve{0xe6, 0x9f, 0x00}, kForecast{0x00, 0x72, 0xb2};
  std::vector<app::ChartBox> columns, marks;
  for (const app::ChartBox& box : chart.boxes) {
    if (box.color == kSolve && box.width > 100) columns.push_back(box);
    if (box.color == kForecast && box.width == 8) marks.push_back(box);
  }
  ASSERT_EQ(columns.size(), 3U);
  EXPECT_NEAR(columns[1].height, 2 * columns[0].height, 1e-6);
  EXPECT_NEAR(columns[1].height, 4 * columns[2].height, 1e-6);
  ASSERT_EQ(marks.size(), 1U);
  EXPECT_NEAR(marks[0].left + 4, columns[1].left + columns[1].width / 2, 1e-6) << "above its frame";
  EXPECT_LT(marks[0].top + 8, columns[1].top);
  const std::string svg = app::chart_svg(chart);
  EXPECT_NE(svg.find("&lt;heap>: 3 frames, deadline 5 ms"), std::string::npos);
  EXPECT_NE(svg.find("late, forecast: 1"), std::string::npos);
  const io::Image image = app::chart_image(chart);
  const auto pixel = [&](double x, double y) {
    const std::size_t at = 3 * (static_cast<std::size_t>(y) * image.width_px + static_cast<std::size_t>(x));
    return std::array<std::uint8_t, 3>{image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
  };
  EXPECT_EQ(pixel(columns[1].left + 20, columns[1].top + 4), kSolve);
  EXPECT_NE(pixel(columns[1].left + 20, columns[1].top - 4), kSolve);
  EXPECT_EQ(pixel(marks[0].left + 4, marks[0].top + 4), kForecast);
}

TEST(FrameChart, CountsAndMarksNoLateFrameOfTheWarmUp) {
  std::vector<simulation::RunFrame> frames{frame_of(8, MissCause::Forecast), frame_of(8, MissCause::Machine),
                                           frame_of(8, MissCause::Forecast)};
  frames[0].warm_up = frames[1].warm_up = true;
  const app::BoxChart chart = app::frame_chart("pile", 5.0, frames);
  const auto marks = std::ranges::count_if(
      chart.boxes, [](const app::ChartBox& box) { return box.width == 8 && box.top == app::plot::kTop - 14; });
  EXPECT_EQ(marks, 1);
  const std::string svg = app::chart_svg(chart);
  EXPECT_NE(svg.find("late, forecast: 1"), std::string::npos);
  EXPECT_EQ(svg.find("late, machine"), std::string::npos);
}

TEST(FrameChart, ShowsTheSlowestOfManyFramesAndIsMadeOfNone) {
  std::vector<simulation::RunFrame> frames(100'000, frame_of(1));
  frames[77'777] = frame_of(1.5);
  const app::BoxChart chart = app::frame_chart("pile", std::nullopt, frames);
  EXPECT_LT(chart.boxes.size(), 3000U);
  const auto tallest = std::max_element(chart.boxes.begin() + 1, chart.boxes.end(),
                                        [](const auto& a, const auto& b) { return a.height < b.height; });
  EXPECT_NEAR(tallest->left, 80 + 1100 * 0.77777, 2);
  EXPECT_FALSE(app::chart_svg(app::frame_chart("pile", 4.0, {})).empty());
}

/// The boxes of a colour but for those of the legend.
std::vector<app::ChartBox> boxes_of(const app::BoxChart& chart, const app::ChartColor& color) {
  std::vector<app::ChartBox> boxes;
  for (const app::ChartBox& box : chart.boxes) {
    if (box.color == color && box.top >= app::plot::kTop - 1) boxes.push_back(box);
  }
  return boxes;
}

bool has_text(const app::BoxChart& chart, const std::string& text) {
  return std::ranges::any_of(chart.texts, [&](const app::ChartText& t) { return t.text == text; });
}

TEST(FrameChart, NumbersFramesAsTheirRunDoes) {
  std::vector<simulation::RunFrame> frames(3, frame_of(1));
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].report.frame = 1234 + i;
  const app::BoxChart chart = app::frame_chart("pile", std::nullopt, frames);
  for (const char* number : {"1234", "1235", "1236"}) EXPECT_TRUE(has_text(chart, number)) << number;
}

TEST(LevelChart, StacksPairsByLevelAndNamesThoseThereAre) {
  std::vector<simulation::RunFrame> frames(2);
  frames[0].report.level_histogram = {10, 0, 30};
  frames[1].report.level_histogram = {20, 0, 0};
  frames[1].report.level_histogram[kPolygonBin] = 20;
  const std::optional<app::BoxChart> chart = app::level_chart("<heap>", frames);
  ASSERT_TRUE(chart);
  constexpr app::ChartColor kRoot{125, 46, 153}, kSecond{33, 168, 140}, kPolygons{247, 140, 51};
  const std::vector<app::ChartBox> root = boxes_of(*chart, kRoot), second = boxes_of(*chart, kSecond);
  ASSERT_EQ(root.size(), 2U);
  ASSERT_EQ(second.size(), 1U);
  ASSERT_EQ(boxes_of(*chart, kPolygons).size(), 1U);
  EXPECT_NEAR(root[1].height, 2 * root[0].height, 1e-6);
  EXPECT_NEAR(second[0].height, 3 * root[0].height, 1e-6);
  EXPECT_NEAR(second[0].top + second[0].height, root[0].top, 1e-6) << "on top of the level below";
  EXPECT_NEAR(root[0].left + root[0].width, root[1].left, 1e-6);
  EXPECT_TRUE(has_text(*chart, "level 0") && has_text(*chart, "level 2") && has_text(*chart, "polygons"));
  EXPECT_FALSE(has_text(*chart, "level 1"));
}

TEST(LevelChart, IsNoneWithoutPairs) {
  EXPECT_FALSE(app::level_chart("heap", {}));
  EXPECT_FALSE(app::level_chart("heap", std::vector<simulation::RunFrame>(9)));
}

TEST(PercentileChart, RisesFromTheFastestToTheSlowestFrameAndIsOrangeBeyondTheDeadline) {
  std::vector<simulation::RunFrame> frames(90, frame_of(1));
  frames.resize(100, frame_of(10));
  std::shuffle(frames.begin(), frames.end(), std::mt19937_64(1));
  const std::optional<app::BoxChart> chart = app::percentile_chart("heap", 5.0, frames);
  ASSERT_TRUE(chart);
  constexpr app::ChartColor kLine{0x00, 0x72, 0xb2};
  const std::vector<app::ChartBox> in_time = boxes_of(*chart, kLine);
  ASSERT_EQ(in_time.size(), 1U) << "frames of one time are a straight line";
  // 90 % of the frames are the first of two factors of ten.
  EXPECT_NEAR(in_time[0].left, app::plot::kLeft, 1e-9);
  EXPECT_NEAR(in_time[0].width, 0.5 * app::plot::width(*chart), 8);
  double late_right = 0, late_top = 1e9;
  for (const app::ChartBox& box : boxes_of(*chart, app::kChartLate)) {
    late_right = std::max(late_right, box.left + box.width);
    late_top = std::min(late_top, box.top);
  }
  EXPECT_NEAR(late_right, app::plot::kLeft + app::plot::width(*chart), 1e-9);
  // From 0.8 ms to 12.5 ms, log scale.
  EXPECT_NEAR(in_time[0].top - late_top, app::plot::height(*chart) * std::log(10.0) / std::log(12.5 / 0.8), 1e-6);
  for (const char* tick : {"0", "50", "90", "99", "1", "10"}) EXPECT_TRUE(has_text(*chart, tick)) << tick;
  EXPECT_FALSE(has_text(*chart, "99.9"));
}

TEST(PercentileChart, LeavesOutWarmUpAndIsNoneWithoutTimes) {
  std::vector<simulation::RunFrame> frames(10, frame_of(2));
  frames[0] = frame_of(100);
  frames[0].warm_up = true;
  EXPECT_EQ(app::chart_svg(app::percentile_chart("heap", std::nullopt, frames).value()),
            app::chart_svg(app::percentile_chart("heap", std::nullopt, std::span(frames).subspan(1)).value()));
  EXPECT_FALSE(app::percentile_chart("heap", 4.0, {}));
  EXPECT_FALSE(app::percentile_chart("heap", 4.0, std::vector<simulation::RunFrame>(3)));
  EXPECT_FALSE(app::percentile_chart("heap", 4.0, std::span(frames).first(1))) << "nothing but warm-up";
}

}  // namespace
}  // namespace poise::testing
