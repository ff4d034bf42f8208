// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/picture/picture.h"

namespace poise::app {

/// A value of a line; with both ends of an interval it is part of a band.
struct LinePoint {
  double x = 0, y = 0;
  std::optional<double> low, high;
};

/// A line with its name at its end; x ascends.
struct ChartLine {
  std::string label;
  std::vector<LinePoint> points;
};

/// Lines over an axis that both begin at 0, or below where values are.
struct LineChart {
  std::string id;  ///< name of its files, and of its element on a page
  std::string title, note, x_label;
  std::vector<ChartLine> lines;
};

/// The chart for papers and slides: white, 900 x 480, in colours that most people with impaired colour vision tell
/// apart (Okabe and Ito 2008).
std::string line_chart_svg(const LineChart& chart);
/// The same as an image. Letters that io::draw_text does not know are left blank.
io::Image line_chart_image(const LineChart& chart);

}  // namespace poise::app
