// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "app/report/frame_chart.h"
#include "scene/run/milliseconds.h"

namespace poise::app {
namespace {

constexpr const ChartColor& kLine = kChartLines[0];
constexpr double kLineWidth = 3;

/// A range of values whose logarithms fill the plot.
struct LogScale {
  double least = 1, most = 10;
  [[nodiscard]] double operator()(double value) const { return std::log(value / least) / std::log(most / least); }
};

/// 1, 2 and 5 of each power of ten, or the powers alone where the range is wide.
void time_ticks(const LogScale& scale, BoxChart& chart) {
  constexpr double kWide = 300;
  for (double power = std::pow(10, std::floor(std::log10(scale.least))); power <= scale.most; power *= 10) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double tick = factor * power;
      if (tick < scale.least || tick > scale.most || (factor > 1 && scale.most > kWide * scale.least)) continue;
      plot::tick_up(chart, scale(tick), fmt::format("{:g}", tick));
    }
  }
}

/// Appends a column of the line; one that goes on at the same height makes the box before it longer.
void add_piece(const ChartBox& piece, BoxChart& chart) {
  ChartBox& last = chart.boxes.back();
  const bool goes_on = last.left + last.width == piece.left && last.top == piece.top && last.height == piece.height &&
                       last.color == piece.color;
  if (goes_on) {
    last.width += piece.width;
  } else {
    chart.boxes.push_back(piece);
  }
}

}  // namespace

std::optional<BoxChart> percentile_chart(const std::string& scene, std::optional<double> deadline_ms,
                                         std::span<const simulation::RunFrame> frames) {
  std::vector<double> times;
  for (const simulation::RunFrame& frame : frames) {
    if (!frame.warm_up && frame.report.times.total.count() > 0) times.push_back(ms(frame.report.times.total));
  }
  if (times.empty()) return std::nullopt;
  std::sort(times.begin(), times.end());
  const auto count = static_cast<double>(times.size());
  const LogScale up{0.8 * times.front(), 1.25 * std::max(times.back(), deadline_ms.value_or(0))};
  // One in so many frames is slower: 1 for all, 100 for the 99th percentile.
  const LogScale along{1, std::max(10.0, count)};

  BoxChart chart = plot::begin(fmt::format("{}: time that so many frames do not exceed{}", scene,
                                           deadline_ms ? fmt::format(", deadline {:g} ms", *deadline_ms) : ""),
                               "ms", "% of frames");
  time_ticks(up, chart);
  plot::tick_along(chart, along(1), "0");
  plot::tick_along(chart, along(2), "50");
  for (double one_in = 10; one_in <= along.most; one_in *= 10)
    plot::tick_along(chart, along(one_in), fmt::format("{:.10g}", 100 - 100 / one_in));
  if (deadline_ms) plot::dashes(chart, up(*deadline_ms), kChartLate);
  const auto columns = static_cast<std::size_t>(plot::width(chart));
  double before = plot::y(chart, up(times.front()));
  for (std::size_t column = 0; column < columns; ++column) {
    const double share = (static_cast<double>(column) + 0.5) / static_cast<double>(columns);
    const double slower = count * std::pow(along.most, -share);
    const auto rank = static_cast<std::size_t>(std::clamp(count - slower, 0.0, count - 1));
    const double y = plot::y(chart, up(times[rank]));
    // Up to where the line was in the column before, so that it has no gaps.
    const double top = std::min(y, before), below = std::max(y, before);
    add_piece({plot::kLeft + static_cast<double>(column), top - kLineWidth / 2, 1, below - top + kLineWidth,
               deadline_ms && times[rank] > *deadline_ms ? kChartLate : kLine},
              chart);
    before = y;
  }
  return chart;
}

}  // namespace poise::app
