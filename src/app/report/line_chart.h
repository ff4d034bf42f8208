// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/picture/picture.h"

namespace poise::app {

/// A value of a line; with both ends of an interval it is part of a band. What is not finite, and on a logarithmic axis
/// what is not positive, is a gap.
struct LinePoint {
  double x = 0, y = 0;
  std::optional<double> low, high;
};

/// How the values of a line are drawn.
enum class LineMarks : std::uint8_t { LineAndDots, Line, Dots };

/// A line with its name at its end; x ascends.
struct ChartLine {
  std::string label;
  std::vector<LinePoint> points;
  LineMarks marks = LineMarks::LineAndDots;
};

/// A dashed line across the chart, such as a deadline.
struct ChartLevel {
  std::string label;
  double y = 0;
  std::optional<std::size_t> line;  ///< which line it belongs to, whose colour it has
};

/// Lines over axes that begin at 0, or below where values are, unless the chart says something else.
struct LineChart {
  std::string id;                    ///< name of its files, and of its element on a page
  std::string title, note, x_label;  ///< the title is what goes upwards, with its unit
  std::vector<ChartLine> lines;
  std::vector<ChartLevel> levels = {};
  bool x_log = false, y_log = false;
  bool x_measured = false;                ///< and not chosen for a run: a logarithmic axis has round numbers
  bool y_from_data = false;               ///< it begins near the least value instead of at 0
  std::vector<std::string> x_names = {};  ///< where not empty, x = 0, 1, ... are these
};

/// The chart for papers and slides, 900 x 480: on a dark ground where a browser prefers that, else on a light one.
std::string line_chart_svg(const LineChart& chart);
/// The same as an image, on a light ground. Letters that io::draw_text does not know are left blank.
io::Image line_chart_image(const LineChart& chart);

}  // namespace poise::app
