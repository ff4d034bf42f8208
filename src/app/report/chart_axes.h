// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "app/report/line_chart.h"

namespace poise::app {

struct ChartTick {
  double at = 0;  ///< value
  std::string text;
};

/// An axis of a chart. Invariant: most > least, both positive where it is logarithmic.
struct ChartAxis {
  double least = 0, most = 1;
  bool log = false;
  std::vector<ChartTick> ticks;
  /// Where a value is along it: 0 at `least`, 1 at `most`.
  [[nodiscard]] double share(double value) const;
  /// Whether a value has a place on it.
  [[nodiscard]] bool shows(double value) const;
};

/// The axes of a chart, with about five round ticks each. They reach a little beyond all values, so that no line lies
/// on an edge.
ChartAxis x_axis_of(const LineChart& chart);
ChartAxis y_axis_of(const LineChart& chart);

/// A name beside the end of a line or of a level: where it is wanted and put, as shares of the height above the bottom.
struct ChartName {
  std::string text;
  double end = 0;  ///< of the line
  double at = 0;
  std::size_t line = 0;  ///< number of the line, or of the level
  bool is_level = false;
};
/// The names of all lines, then of all levels, at least `gap` apart.
std::vector<ChartName> names_of(const LineChart& chart, const ChartAxis& y, double gap);

/// In how many rows the texts of the ticks of an axis stand, so that none lies over its neighbour: tick k in row
/// k % rows. `character` is the width of a character as a share of the axis.
std::size_t tick_rows(const ChartAxis& axis, double character);

}  // namespace poise::app
