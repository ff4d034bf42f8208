// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/picture/picture.h"
#include "scene/run/run_report.h"

namespace poise::app {

/// A filled rectangle of a chart in pixels from its top left corner.
struct ChartBox {
  double left = 0, top = 0, width = 0, height = 0;
  std::array<std::uint8_t, 3> color{};
};
struct ChartText {
  enum class Anchor : std::uint8_t { Start, Middle, End };
  double x = 0, y = 0;  ///< of the anchor, and the line on which letters stand
  Anchor anchor = Anchor::Start;
  std::string text;
};

/// Frame times against the deadline: stages stacked, a mark of the colour of its cause above each late frame. Where
/// there are more frames than columns, a column is the slowest frame of its part of the run.
struct FrameChart {
  std::uint32_t width_px = 1200, height_px = 480;
  std::vector<ChartBox> boxes;  ///< later ones lie over earlier ones
  std::vector<ChartText> texts;
};

FrameChart frame_chart(const std::string& scene, std::optional<double> deadline_ms,
                       std::span<const simulation::RunFrame> frames);
std::string frame_chart_svg(const FrameChart& chart);
io::Image frame_chart_image(const FrameChart& chart);

}  // namespace poise::app
