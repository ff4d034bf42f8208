// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "app/report/box_chart.h"
#include "scene/run/run_report.h"

namespace poise::app {

/// Place of a frame along the plot, from 0 to 1.
inline double share_of_frame(double frame, std::size_t frames) {
  return frame / std::max(1.0, static_cast<double>(frames));
}

/// Numbers of frames below the plot, as the run counts them.
inline void frame_ticks(BoxChart& chart, std::span<const simulation::RunFrame> frames) {
  const auto count = static_cast<double>(frames.size());
  const double step = std::max(1.0, plot::tick_step(std::max(count, 4.0)));
  const double first = frames.empty() ? 0 : static_cast<double>(frames.front().report.frame);
  for (double frame = std::ceil(first / step) * step; frame < first + count; frame += step)
    plot::tick_along(chart, share_of_frame(frame - first, frames.size()), fmt::format("{:.0f}", frame));
}

/// Calls `draw(frame, left_px, width_px)` for each column of the plot. Where there are more frames than columns, a
/// column is the greatest of its frames by `value(frame)`.
template <class Value, class Draw>
void draw_columns(const BoxChart& chart, std::span<const simulation::RunFrame> frames, Value value, Draw draw) {
  const std::size_t count = std::min(static_cast<std::size_t>(plot::width(chart)), frames.size());
  for (std::size_t column = 0; column < count; ++column) {
    const std::size_t first = column * frames.size() / count;
    const std::size_t last = (column + 1) * frames.size() / count;
    const auto part = frames.subspan(first, last - first);
    const auto& greatest =
        *std::max_element(part.begin(), part.end(), [&](const auto& a, const auto& b) { return value(a) < value(b); });
    const double left = plot::x(chart, share_of_frame(static_cast<double>(first), frames.size()));
    draw(greatest, left, plot::x(chart, share_of_frame(static_cast<double>(last), frames.size())) - left);
  }
}

}  // namespace poise::app
