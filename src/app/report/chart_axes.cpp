// SPDX-License-Identifier: MIT
#include "app/report/chart_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

namespace poise::app {
namespace {

// Shares of an axis that it reaches beyond the values. Chosen.
constexpr double kBeyond = 0.05;
// Of more places along x than this, only round ones have a tick. Chosen.
constexpr std::size_t kMostOwnTicks = 9;

struct Range {
  double least = std::numeric_limits<double>::infinity(), most = -std::numeric_limits<double>::infinity();
  void add(double value, bool log) {
    if (!std::isfinite(value) || (log && !(value > 0))) return;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  [[nodiscard]] bool empty() const { return !(least <= most); }
};

// A round step of which about five make up the range.
double tick_step(double range) {
  const double power = std::pow(10, std::floor(std::log10(range / 6)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= 0.999 * range / 6) return factor * power;
  }
  return 10 * power;
}

// Thousands have commas; very large and small powers of ten are short.
std::string tick_text(double value) {
  const double magnitude = std::abs(value);
  if (value != 0 && (magnitude < 0.9e-3 || magnitude >= 0.9e7)) {
    const std::string text = fmt::format("{:.3g}", value);
    const std::size_t at = text.find('e');
    if (at != std::string::npos) return text.substr(0, at) + fmt::format("e{}", std::stoi(text.substr(at + 1)));
    return text;
  }
  std::string text = fmt::format("{:.6g}", value);
  if (magnitude >= 9999.5 && text.find_first_of(".e") == std::string::npos) {
    for (std::size_t at = text.size() - 3; at > (value < 0 ? 1U : 0U) && at < text.size(); at -= 3)
      text.insert(at, ",");
  }
  return text;
}

// Three digits tell which run it was, unless it is a whole number.
double rounded(double value) { return value == std::round(value) ? value : std::stod(fmt::format("{:.3g}", value)); }

std::vector<ChartTick> even_ticks(double least, double most) {
  std::vector<ChartTick> made;
  const double step = tick_step(most - least);
  for (double k = std::ceil(least / step - 1e-9); k * step <= most + 1e-9 * step; ++k)
    made.push_back({k == 0 ? 0 : k * step, tick_text(k == 0 ? 0 : k * step)});
  return made;
}

std::vector<ChartTick> log_ticks(double least, double most, int every, const std::vector<double>& factors) {
  std::vector<ChartTick> made;
  for (int power = static_cast<int>(std::floor(std::log10(least))); std::pow(10, power) <= most; ++power) {
    if (power % every != 0) continue;
    for (const double factor : factors) {
      const double value = factor * std::pow(10, power);
      if (value >= least && value <= most) made.push_back({value, tick_text(value)});
    }
  }
  return made;
}

// Powers of ten, of long axes not all of them; of short ones what is between them too.
std::vector<ChartTick> log_ticks(double least, double most) {
  constexpr std::size_t kFewest = 3;
  const auto every = std::max(1, static_cast<int>(std::ceil(std::log10(most / least) / 7)));
  for (const std::vector<double>& factors : {std::vector<double>{1}, std::vector<double>{1, 2, 5}}) {
    std::vector<ChartTick> made = log_ticks(least, most, every, factors);
    if (made.size() >= kFewest) return made;
  }
  return even_ticks(least, most);
}

ChartAxis log_axis(Range range) {
  if (range.empty()) range = {1, 10};
  const double beyond = std::max(std::pow(range.most / range.least, kBeyond), 1.1);
  ChartAxis axis{range.least / beyond, range.most * beyond, true, {}};
  axis.ticks = log_ticks(axis.least, axis.most);
  return axis;
}

}  // namespace

double ChartAxis::share(double value) const {
  return log ? std::log(value / least) / std::log(most / least) : (value - least) / (most - least);
}

bool ChartAxis::shows(double value) const { return std::isfinite(value) && (!log || value > 0); }

ChartAxis x_axis_of(const LineChart& chart) {
  if (!chart.x_names.empty()) {
    ChartAxis axis{-0.4, static_cast<double>(chart.x_names.size()) - 0.6, false, {}};
    for (std::size_t i = 0; i < chart.x_names.size(); ++i)
      axis.ticks.push_back({static_cast<double>(i), chart.x_names[i]});
    return axis;
  }
  Range range;
  std::set<double> places;
  for (const ChartLine& line : chart.lines) {
    for (const LinePoint& point : line.points) {
      range.add(point.x, chart.x_log);
      places.insert(point.x);
    }
  }
  if (chart.x_log) {
    ChartAxis axis = log_axis(range);
    // What was chosen for a run is what is read; dots stand where the measurement has put them.
    const bool is_chosen = !chart.x_measured && std::ranges::any_of(chart.lines, [](const ChartLine& line) {
      return line.marks != LineMarks::Dots;
    });
    if (is_chosen && !places.empty() && *places.begin() > 0 && places.size() <= kMostOwnTicks) {
      axis.ticks.clear();
      for (const double place : places) axis.ticks.push_back({place, tick_text(rounded(place))});
    }
    return axis;
  }
  if (range.empty()) range = {0, 1};
  ChartAxis axis{std::min(0.0, range.least), range.most, false, {}};
  if (!(axis.most > axis.least)) axis.most = axis.least + 1;
  axis.ticks = even_ticks(axis.least, axis.most);
  return axis;
}

ChartAxis y_axis_of(const LineChart& chart) {
  Range range;
  for (const ChartLine& line : chart.lines) {
    for (const LinePoint& point : line.points) {
      range.add(point.y, chart.y_log);
      if (!point.low || !point.high) continue;
      range.add(*point.low, chart.y_log);
      range.add(*point.high, chart.y_log);
    }
  }
  for (const ChartLevel& level : chart.levels) range.add(level.y, chart.y_log);
  if (chart.y_log) return log_axis(range);
  if (!chart.y_from_data || range.empty()) range.add(0, false);
  if (!(range.most > range.least)) {
    const double room = chart.y_from_data && range.most != 0 ? 0.1 * std::abs(range.most) : 1;
    range = {range.least - (chart.y_from_data ? room : 0), range.most + room};
  }
  const double beyond = kBeyond * (range.most - range.least);
  ChartAxis axis{range.least - beyond, range.most + beyond, false, {}};
  axis.ticks = even_ticks(axis.least, axis.most);
  return axis;
}

std::vector<ChartName> names_of(const LineChart& chart, const ChartAxis& y, double gap) {
  std::vector<ChartName> names;
  for (std::size_t i = 0; i < chart.lines.size(); ++i) {
    const auto& points = chart.lines[i].points;
    const auto last = std::find_if(points.rbegin(), points.rend(), [&](const LinePoint& p) { return y.shows(p.y); });
    const double end = last == points.rend() ? 0 : y.share(last->y);
    names.push_back({chart.lines[i].label, end, end, i, false});
  }
  for (std::size_t i = 0; i < chart.levels.size(); ++i) {
    if (!y.shows(chart.levels[i].y) || chart.levels[i].label.empty()) continue;
    const double end = y.share(chart.levels[i].y);
    names.push_back({chart.levels[i].label, end, end, i, true});
  }
  std::vector<std::size_t> order(names.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return names[a].end < names[b].end; });
  double least = 0;
  for (const std::size_t i : order) {
    names[i].at = std::max(names[i].end, least);
    least = names[i].at + gap;
  }
  double most = 1;
  for (auto i = order.rbegin(); i != order.rend(); ++i) {
    names[*i].at = std::min(names[*i].at, most);
    most = names[*i].at - gap;
  }
  return names;
}

std::size_t tick_rows(const ChartAxis& axis, double character) {
  constexpr std::size_t kMostRows = 4;
  for (std::size_t rows = 1; rows < kMostRows; ++rows) {
    bool fits = true;
    for (std::size_t i = rows; i < axis.ticks.size(); ++i) {
      const ChartTick &before = axis.ticks[i - rows], &tick = axis.ticks[i];
      const double room = axis.share(tick.at) - axis.share(before.at);
      const auto characters = static_cast<double>(tick.text.size() + before.text.size()) / 2 + 1;
      fits = fits && room >= characters * character;
    }
    if (fits) return rows;
  }
  return kMostRows;
}

}  // namespace poise::app
