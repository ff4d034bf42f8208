// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "app/report/line_chart.h"

namespace poise::app {

/// Where a chart stands in a picture, in pixels from its lower left corner, its names and axes included.
struct PanelBox {
  double left = 0, bottom = 0, width = 0, height = 0;
};
struct PictureSize {
  double width = 0, height = 0;
};

/// A part of a script for gnuplot that draws a chart there: in the style of all pictures of studies (plot_style), with
/// names beside the ends of its lines. It stands between `set multiplot` and `unset multiplot`.
std::string panel_plot(const LineChart& chart, const PanelBox& box, const PictureSize& picture);

/// The whole script: the charts in rows of so many. Empty without charts.
std::string charts_plot(const std::vector<LineChart>& charts, std::size_t columns);

/// Takes away lines without a value, and charts without a line.
void leave_out_empty(std::vector<LineChart>& charts);

/// Names x = 0, 1, ... of a chart; where they are many or long, by their numbers, which the note explains.
void name_places(LineChart& chart, std::vector<std::string> names, const std::string& what);

}  // namespace poise::app
