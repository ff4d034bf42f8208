// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/picture/chart_theme.h"
#include "app/picture/picture.h"

namespace poise::app {

/// A filled rectangle of a chart in pixels from its top left corner.
struct ChartBox {
  double left = 0, top = 0, width = 0, height = 0;
  ChartColor color{};
};
struct ChartText {
  enum class Anchor : std::uint8_t { Start, Middle, End };
  double x = 0, y = 0;  ///< of the anchor, and the line on which letters stand
  Anchor anchor = Anchor::Start;
  std::string text;
};

/// A chart for papers and slides.
struct BoxChart {
  std::uint32_t width_px = 1200, height_px = 480;
  std::vector<ChartBox> boxes;  ///< later ones lie over earlier ones
  std::vector<ChartText> texts;
};

/// On a dark ground where a browser prefers that, else on a light one.
std::string chart_svg(const BoxChart& chart);
/// On a light ground.
io::Image chart_image(const BoxChart& chart);

/// What charts share: the plot, in which places are shares of its width from the left, and of its height from below.
namespace plot {
inline constexpr double kLeft = 80, kRight = 20, kTop = 96, kBottom = 52;  // of the chart, around the plot

[[nodiscard]] double width(const BoxChart& chart);
[[nodiscard]] double height(const BoxChart& chart);
[[nodiscard]] double x(const BoxChart& chart, double share);
/// Above the plot for shares above 1.
[[nodiscard]] double y(const BoxChart& chart, double share);

/// An empty chart with its title, the unit of what goes up, and the name of what goes along.
BoxChart begin(const std::string& title, const std::string& up, const std::string& along);
void text(BoxChart& chart, double x, double y, ChartText::Anchor anchor, std::string text);
/// A line across the plot with its value to the left, and a value below the plot.
void tick_up(BoxChart& chart, double share, const std::string& value);
void tick_along(BoxChart& chart, double share, const std::string& value);
/// A dashed line across the plot.
void dashes(BoxChart& chart, double share, const ChartColor& color);
/// A colour and its name, from x on in one of two rows (0 or 1) of the legend; where the next one begins.
double legend_entry(BoxChart& chart, double x, int row, const ChartColor& color, const std::string& name);
/// A round step of which four to ten make up the range.
[[nodiscard]] double tick_step(double range);
}  // namespace plot

}  // namespace poise::app
