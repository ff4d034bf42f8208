// SPDX-License-Identifier: MIT
#include "studies/study_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/picture/chart_theme.h"
#include "app/report/chart_axes.h"
#include "studies/gnuplot.h"

namespace poise::app {
namespace {

// Of a panel, in pixels. Chosen; a letter of "sans,13" is about as wide in words.
constexpr double kChartWidth = 700, kOnlyWidth = 900, kChartHeight = 440;
constexpr double kLeftEdge = 84, kTopEdge = 46, kBottomEdge = 74, kTextRow = 18, kLetter = 9.8, kNameGap = 19;
constexpr double kBeside = 34;  // from the axes to the names
constexpr std::size_t kMostNames = 14;
constexpr std::size_t kMostLetters = 100;

std::string quoted(std::string text) {
  std::ranges::replace(text, '"', '\'');
  std::ranges::replace(text, '\\', '/');
  return '"' + text + '"';
}

// A power of ten as one.
std::string shown_tick(const std::string& text) {
  const std::size_t at = text.find('e');
  const bool is_power =
      at != std::string::npos && at > 0 && at + 1 < text.size() && text.find_first_not_of("0123456789.", 0) == at;
  if (!is_power) return text;
  const std::string power = "10^{" + text.substr(at + 1) + "}";
  return text.substr(0, at) == "1" ? power : text.substr(0, at) + "x" + power;
}

std::string axis_plot(const char* name, const ChartAxis& axis, std::size_t rows) {
  std::string text = fmt::format("{}set logscale {}\nset {}range [{:g}:{:g}]\nset {}tics scale 0 enhanced (",
                                 axis.log ? "" : "un", name, name, axis.least, axis.most, name);
  for (std::size_t i = 0; i < axis.ticks.size(); ++i) {
    std::string drop;
    for (std::size_t row = 0; row < i % rows; ++row) drop += "\\n";
    const std::string shown = quoted(shown_tick(axis.ticks[i].text));
    text += fmt::format("{}\"{}{} {:g}", i == 0 ? "" : ", ", drop, shown.substr(1), axis.ticks[i].at);
  }
  return text + ")\n";
}

const char* with_of(LineMarks marks) {
  switch (marks) {
    case LineMarks::LineAndDots:
      return "linespoints";
    case LineMarks::Line:
      return "lines";
    case LineMarks::Dots:
      return "points";
  }
  return "linespoints";
}

// Values of a line, with its interval where it has one; gaps are NaN.
std::string line_block(const ChartLine& line, std::size_t number, const ChartAxis& y) {
  std::string text = fmt::format("$line{} << EOD\n", number);
  for (const LinePoint& point : line.points) {
    const double value = y.shows(point.y) ? point.y : std::nan("");
    const auto end = [&](const std::optional<double>& at) { return at && y.shows(*at) ? *at : value; };
    const auto cell = [](double at) { return std::isfinite(at) ? fmt::format("{:.9g}", at) : std::string("NaN"); };
    text += fmt::format("{:.9g} {} {} {}\n", point.x, cell(value), cell(end(point.low)), cell(end(point.high)));
  }
  return text + "EOD\n";
}

bool has_band(const ChartLine& line) {
  return std::ranges::any_of(line.points, [](const LinePoint& point) { return point.low && point.high; });
}

// Names beside the ends, and thin lines that lead to them.
std::string names_plot(const LineChart& chart, const ChartAxis& x, const ChartAxis& y, double gap) {
  std::string text;
  std::size_t number = 0;
  for (const ChartName& name : names_of(chart, y, gap)) {
    ++number;
    const bool is_own = name.is_level && !chart.levels[name.line].line;
    const std::size_t line = name.is_level ? chart.levels[name.line].line.value_or(0) : name.line;
    const std::string color = fmt::format("rgb \"{}\"", is_own ? color_text(kChartInk) : plot_color(line));
    text += fmt::format("set label {} {} at graph 1,{:.4f} offset character 1.4,0 left noenhanced textcolor {}\n",
                        number, quoted(name.text), name.at, color);
    if (name.is_level) continue;
    const auto& points = chart.lines[name.line].points;
    const auto last = std::find_if(points.rbegin(), points.rend(), [&](const LinePoint& p) { return y.shows(p.y); });
    // Of dots the last one is no end.
    if (last == points.rend() || chart.lines[name.line].marks == LineMarks::Dots) continue;
    text += fmt::format("set arrow {} from graph {:.4f},{:.4f} to graph 1.012,{:.4f} nohead lw 0.7 lc {}\n", number,
                        x.share(last->x), name.end, name.at, color);
  }
  return text;
}

}  // namespace

std::string panel_plot(const LineChart& chart, const PanelBox& box, const PictureSize& picture) {
  const ChartAxis x = x_axis_of(chart), y = y_axis_of(chart);
  std::size_t longest = 0;
  for (const ChartLine& line : chart.lines) longest = std::max(longest, line.label.size());
  for (const ChartLevel& level : chart.levels) longest = std::max(longest, level.label.size());
  const double right_edge = kBeside + kLetter * static_cast<double>(longest);
  const double across = box.width - kLeftEdge - right_edge;
  const std::size_t rows = tick_rows(x, kLetter / across);
  const double bottom_edge = kBottomEdge + kTextRow * static_cast<double>(rows - 1);
  const double up = box.height - kTopEdge - bottom_edge;
  std::string text = fmt::format(
      "set lmargin at screen {:.4f}\nset rmargin at screen {:.4f}\nset bmargin at screen {:.4f}\nset tmargin at screen "
      "{:.4f}\nunset key\nunset label\nunset arrow\nset autoscale\nset title {} noenhanced textcolor rgb \"{}\"\nset "
      "xlabel {} noenhanced textcolor rgb \"{}\" offset character 0,{}\n",
      (box.left + kLeftEdge) / picture.width, (box.left + kLeftEdge + across) / picture.width,
      (box.bottom + bottom_edge) / picture.height, (box.bottom + bottom_edge + up) / picture.height,
      quoted(chart.title), color_text(kChartInk), quoted(chart.x_label), color_text(kChartInk),
      rows == 1 ? "0" : fmt::format("-{:g}", 0.35 * static_cast<double>(rows - 1)));
  text += axis_plot("x", x, rows) + axis_plot("y", y, 1) + names_plot(chart, x, y, kNameGap / up);
  std::string plots;
  const auto add = [&](const std::string& plot) { plots += (plots.empty() ? "" : ", ") + plot; };
  for (std::size_t i = 0; i < chart.lines.size(); ++i) {
    text += line_block(chart.lines[i], i, y);
    if (has_band(chart.lines[i]))
      add(fmt::format("$line{0} using 1:3:4 with filledcurves lt {1} fs transparent solid 0.14 noborder", i, i + 1));
  }
  for (const ChartLevel& level : chart.levels) {
    const std::string color =
        level.line ? fmt::format("lt {}", *level.line + 1) : fmt::format("lc rgb \"{}\"", color_text(kChartInk));
    add(fmt::format("{:.9g} with lines {} lw 1.5 dt 2", level.y, color));
  }
  for (std::size_t i = 0; i < chart.lines.size(); ++i)
    add(fmt::format("$line{} using 1:2 with {} lt {}", i, with_of(chart.lines[i].marks), i + 1));
  return text + "plot " + plots + "\n";
}

std::string charts_plot(const std::vector<LineChart>& charts, std::size_t columns) {
  if (charts.empty()) return "";
  columns = std::min(columns, charts.size());
  const std::size_t rows = (charts.size() + columns - 1) / columns;
  const double width = columns == 1 ? kOnlyWidth : kChartWidth;
  const PictureSize size{width * static_cast<double>(columns), kChartHeight * static_cast<double>(rows)};
  std::string text =
      plot_style(static_cast<std::size_t>(size.width), static_cast<std::size_t>(size.height)) + "set multiplot\n";
  for (std::size_t i = 0; i < charts.size(); ++i) {
    const auto column = static_cast<double>(i % columns), row = static_cast<double>(i / columns);
    text += panel_plot(charts[i], {width * column, size.height - kChartHeight * (row + 1), width, kChartHeight}, size);
  }
  return text + "unset multiplot\n";
}

void leave_out_empty(std::vector<LineChart>& charts) {
  for (LineChart& chart : charts) {
    const ChartAxis x = x_axis_of(chart), y = y_axis_of(chart);
    // The levels of a line count lines.
    std::vector<std::size_t> places(chart.lines.size());
    std::vector<ChartLine> kept;
    for (std::size_t i = 0; i < chart.lines.size(); ++i) {
      places[i] = kept.size();
      const bool any = std::ranges::any_of(
          chart.lines[i].points, [&](const LinePoint& point) { return x.shows(point.x) && y.shows(point.y); });
      if (any)
        kept.push_back(std::move(chart.lines[i]));
      else
        places[i] = chart.lines.size();
    }
    std::erase_if(chart.levels, [&](ChartLevel& level) {
      if (!level.line) return false;
      level.line = places[*level.line];
      return *level.line == places.size();
    });
    chart.lines = std::move(kept);
  }
  std::erase_if(charts, [](const LineChart& chart) { return chart.lines.empty(); });
}

void name_places(LineChart& chart, std::vector<std::string> names, const std::string& what) {
  std::size_t letters = 0;
  for (const std::string& name : names) letters += name.size() + 1;
  if (names.size() > kMostNames || letters > 2 * kMostLetters) {
    for (std::size_t i = 0; i < names.size(); ++i) names[i] = std::to_string(i + 1);
    chart.x_label = what + ", by number, in the order of the table";
  }
  chart.x_names = std::move(names);
}

}  // namespace poise::app
