// SPDX-License-Identifier: MIT
#include "app/sweep/heat_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poise::app {
namespace {

constexpr double kCellWidth = 72, kCellHeight = 30, kLeft = 110, kTop = 44, kBottom = 46, kRight = 20;

std::string xml_text(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&') {
      safe += "&amp;";
    } else if (c == '<') {
      safe += "&lt;";
    } else if (c == '"') {
      safe += "&quot;";
    } else {
      safe += c;
    }
  }
  return safe;
}

/// Where the values lie: 0 for the least, 1 for the greatest.
struct Scale {
  double least = 0, most = 0;
  bool log = false;

  [[nodiscard]] double share(double value) const {
    if (!(most > least)) return 0;
    if (!log) return (value - least) / (most - least);
    const double from = std::log(std::max(least, most * 1e-4));
    return std::clamp((std::log(std::max(value, most * 1e-4)) - from) / (std::log(most) - from), 0.0, 1.0);
  }
};

Scale scale_of(const HeatMap& map) {
  Scale scale;
  bool first = true;
  for (const HeatMap::Cell& cell : map.cells) {
    if (!cell.value || !std::isfinite(*cell.value)) continue;
    scale.least = first ? *cell.value : std::min(scale.least, *cell.value);
    scale.most = first ? *cell.value : std::max(scale.most, *cell.value);
    first = false;
  }
  scale.log = scale.least >= 0 && scale.most > 100 * scale.least;
  return scale;
}

/// From near white to a dark blue; lightness falls evenly, so that it reads without colour too.
std::string color_of(double share) {
  const auto mix = [share](double from, double to) {
    return static_cast<int>(std::lround(from + share * (to - from)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(242, 8), mix(246, 48), mix(250, 107));
}

std::string text_at(double x, double y, const std::string& text, const std::string& attributes) {
  return fmt::format("<text x=\"{:g}\" y=\"{:g}\" {}>{}</text>\n", x, y, attributes, xml_text(text));
}

std::string cell_svg(const HeatMap::Cell& cell, const Scale& scale, double x, double y) {
  const bool known = cell.value && std::isfinite(*cell.value);
  const double share = known ? scale.share(*cell.value) : 0;
  std::string svg =
      fmt::format("<rect x=\"{:g}\" y=\"{:g}\" width=\"{:g}\" height=\"{:g}\" fill=\"{}\" stroke=\"white\"/>\n", x, y,
                  kCellWidth, kCellHeight, known ? color_of(share) : "#dddddd");
  svg += text_at(x + kCellWidth / 2, y + kCellHeight / 2 + 4, known ? fmt::format("{:.3g}", *cell.value) : "-",
                 fmt::format("text-anchor=\"middle\" fill=\"{}\"", share > 0.5 ? "white" : "#1d2733"));
  if (cell.holds == false)
    svg += fmt::format("<path d=\"M{:g} {:g} l{:g} {:g}\" stroke=\"#d55e00\" stroke-width=\"1.5\"/>\n", x + 3,
                       y + kCellHeight - 3, kCellWidth - 6, 6 - kCellHeight);
  return svg;
}

}  // namespace

std::string heat_map_svg(const HeatMap& map) {
  const double width = kLeft + kCellWidth * static_cast<double>(map.x.size()) + kRight;
  const double bottom = kTop + kCellHeight * static_cast<double>(map.y.size());
  const double height = bottom + kBottom;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:g}\" height=\"{1:g}\" viewBox=\"0 0 {0:g} {1:g}\" "
      "font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" "
      "fill=\"white\"/>\n",
      std::max(width, 420.0), height);
  svg += text_at(10, 18, map.title, "font-size=\"14\" font-weight=\"bold\" fill=\"#1d2733\"");
  svg += text_at(10, 36, map.y_label + " upwards; crossed out: the requirements do not hold", "fill=\"#5a6672\"");
  const Scale scale = scale_of(map);
  for (std::size_t row = 0; row < map.y.size(); ++row) {
    const double y = bottom - kCellHeight * static_cast<double>(row + 1);
    svg += text_at(kLeft - 8, y + kCellHeight / 2 + 4, map.y[row], "text-anchor=\"end\" fill=\"#1d2733\"");
    for (std::size_t column = 0; column < map.x.size(); ++column)
      svg +=
          cell_svg(map.cells[row * map.x.size() + column], scale, kLeft + kCellWidth * static_cast<double>(column), y);
  }
  for (std::size_t column = 0; column < map.x.size(); ++column)
    svg += text_at(kLeft + kCellWidth * (static_cast<double>(column) + 0.5), bottom + 17, map.x[column],
                   "text-anchor=\"middle\" fill=\"#1d2733\"");
  svg += text_at(kLeft, bottom + 37, map.x_label, "fill=\"#5a6672\"");
  return svg + "</svg>\n";
}

}  // namespace poise::app
