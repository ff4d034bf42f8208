// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "app/picture/frame_picture.h"
#include "app/report/frame_chart.h"
#include "app/report/frame_columns.h"

namespace poise::app {
namespace {

std::uint64_t pairs_of(const simulation::RunFrame& frame) {
  const auto& levels = frame.report.level_histogram;
  return std::accumulate(levels.begin(), levels.end(), std::uint64_t{0});
}

ChartColor color_of(std::size_t level) {
  ChartColor color;
  const std::array<double, 3> seen = io::level_color(static_cast<int>(level));
  std::ranges::transform(seen, color.begin(),
                         [](double part) { return static_cast<std::uint8_t>(std::lround(255 * part)); });
  return color;
}

}  // namespace

std::optional<BoxChart> level_chart(const std::string& scene, std::span<const simulation::RunFrame> frames) {
  std::array<std::uint64_t, kPolygonBin + 1> sums{};
  double most = 0;
  for (const simulation::RunFrame& frame : frames) {
    for (std::size_t level = 0; level < sums.size(); ++level) sums[level] += frame.report.level_histogram[level];
    most = std::max(most, 1.05 * static_cast<double>(pairs_of(frame)));
  }
  if (most == 0) return std::nullopt;
  BoxChart chart =
      plot::begin(fmt::format("{}: contact pairs by the level that they reached", scene), "pairs", "frame");
  const double step = std::max(1.0, plot::tick_step(most));
  for (double tick = 0; tick <= most; tick += step) plot::tick_up(chart, tick / most, fmt::format("{:g}", tick));
  frame_ticks(chart, frames);
  draw_columns(chart, frames, pairs_of, [&](const simulation::RunFrame& frame, double left, double width) {
    double sum = 0;
    for (std::size_t level = 0; level < sums.size(); ++level) {
      const double from = plot::y(chart, sum / most);
      sum += frame.report.level_histogram[level];
      const double to = plot::y(chart, sum / most);
      if (from > to) chart.boxes.push_back({left, to, width, from - to, color_of(level)});
    }
  });
  double at = plot::kLeft;
  for (std::size_t level = 0; level < sums.size(); ++level) {
    if (sums[level] == 0) continue;
    const std::string name = level == kPolygonBin ? "polygons" : fmt::format("level {}", level);
    at = plot::legend_entry(chart, at, 0, color_of(level), name);
  }
  return chart;
}

}  // namespace poise::app
