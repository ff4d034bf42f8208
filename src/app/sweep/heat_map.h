// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace poise::app {

/// A figure over two axes, one cell for each pair of their values.
struct HeatMap {
  struct Cell {
    std::optional<double> value;  ///< empty: not measured
    std::optional<bool> holds;    ///< whether the requirements hold; empty: not known
  };
  std::string title, x_label, y_label;
  std::vector<std::string> x, y;  ///< values of the axes; y from below
  std::vector<Cell> cells;        ///< x.size() for each value of y
};

/// The map as SVG: light where the value is small, dark where it is large, on a logarithmic scale where the values span
/// more than two decades and none is negative; cells in which the requirements do not hold are crossed out.
std::string heat_map_svg(const HeatMap& map);

}  // namespace poise::app
