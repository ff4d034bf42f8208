// SPDX-License-Identifier: MIT
#include "app/sweep/sweep_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "app/sweep/heat_map.h"
#include "app/sweep/sweep_text.h"
#include "scene/made_by.h"

namespace poise::app {
namespace {

using sweep::Axis;
using sweep::Group;

/// More curves than this nobody looks at, and each is a file.
constexpr std::size_t kMostCharts = 48;
constexpr std::size_t kMostLines = 8;
constexpr std::size_t kMostTableRows = 500;

bool varies(const Axis& axis) { return axis.values.size() > 1 && axis.name != "seed"; }

bool has_numbers(const Axis& axis) {
  return std::ranges::all_of(axis.values, [](const sweep::Setting& value) { return value.number.has_value(); });
}

/// Whether its values are better told apart on a logarithmic axis.
bool spans_much(const Axis& axis) {
  constexpr double kMuch = 20;
  double least = 0, most = 0;
  for (const sweep::Setting& value : axis.values) {
    const double number = value.number.value_or(0);
    least = &value == axis.values.data() ? number : std::min(least, number);
    most = &value == axis.values.data() ? number : std::max(most, number);
  }
  return least > 0 && most > kMuch * least;
}

double number_of(const Group& group, const std::string& name) {
  const auto found = std::ranges::find(group.settings, name, &sweep::Setting::name);
  return found == group.settings.end() ? 0 : found->number.value_or(0);
}

std::vector<std::string> shown_figures(const sweep::SweepSpec& spec, const sweep::Results& results) {
  if (!spec.figures.empty()) return spec.figures;
  const bool timed = std::ranges::any_of(results.trials, [](const auto& result) { return result.trial.timed; });
  return timed ? std::vector<std::string>{"misses.rate", "frame_ms.p99"}
               : std::vector<std::string>{"levels.mean", "frame_ms.p50"};
}

/// Where a figure is in the groups; empty: no run has it.
std::optional<std::size_t> index_of(const sweep::Results& results, const std::string& figure) {
  const auto found = std::ranges::find(results.figures, figure);
  if (found == results.figures.end()) return std::nullopt;
  return static_cast<std::size_t>(found - results.figures.begin());
}

/// The axis whose values are the lines of a chart along `along`: the last other one that has not too many.
std::string line_axis(const sweep::SweepSpec& spec, const std::string& along) {
  std::string chosen;
  for (const Axis& axis : spec.axes) {
    if (varies(axis) && axis.name != along && axis.values.size() <= kMostLines) chosen = axis.name;
  }
  return chosen;
}

/// Charts of one figure along one axis: one for each combination of scene and the axes that are neither along it nor
/// lines.
std::vector<LineChart> charts_along(const sweep::SweepSpec& spec, const std::vector<Group>& groups, const Axis& along,
                                    const std::string& figure, std::size_t at) {
  const std::string lines = line_axis(spec, along.name);
  std::vector<LineChart> charts;
  for (const Group& group : groups) {
    if (!group.mean[at]) continue;
    const std::string rest = sweep::group_label(spec, group, {along.name, lines});
    const std::string title = fmt::format("{}: {}", figure, rest);
    auto chart = std::ranges::find(charts, title, &LineChart::title);
    if (chart == charts.end()) {
      LineChart added;
      added.id = picture_name(fmt::format("{} along {} {}", figure, along.name, rest));
      added.title = title;
      // Names of lines are short, so they are the values alone.
      added.note = (lines.empty() ? std::string() : fmt::format("A line for each {}. ", lines)) +
                   "Means over seeds and repeats; bands from the least to the greatest.";
      added.x_log = spans_much(along);
      added.x_label = along.name;
      chart = charts.insert(charts.end(), std::move(added));
    }
    const std::string label = lines.empty() ? group.scene : sweep::value_of(group, lines);
    auto line = std::ranges::find(chart->lines, label, &ChartLine::label);
    if (line == chart->lines.end()) line = chart->lines.insert(chart->lines.end(), {label, {}});
    LinePoint point{number_of(group, along.name), *group.mean[at], {}, {}};
    if (group.done > 1) {
      point.low = group.least[at];
      point.high = group.most[at];
    }
    line->points.push_back(point);
  }
  for (LineChart& chart : charts) {
    for (ChartLine& line : chart.lines) std::ranges::stable_sort(line.points, {}, &LinePoint::x);
  }
  return charts;
}

std::optional<LineChart> frontier_chart(const sweep::SweepSpec& spec,
                                        const std::vector<sweep::FrontierLine>& frontier) {
  LineChart chart;
  chart.id = "frontier";
  for (const sweep::FrontierLine& line : frontier) {
    ChartLine drawn{line.label, {}};
    for (const sweep::FrontierPoint& point : line.points) {
      if (point.largest) drawn.points.push_back({point.at, *point.largest, {}, {}});
    }
    if (!drawn.points.empty()) chart.lines.push_back(std::move(drawn));
  }
  if (chart.lines.empty()) return std::nullopt;
  chart.title = fmt::format("Largest {} at which {}", spec.frontier->largest, fmt::join(spec.requirements, " and "));
  chart.note = "Of the values that were measured; all smaller ones hold too. A top value is a lower bound.";
  chart.x_label = spec.frontier->against;
  const auto against = std::ranges::find(spec.axes, spec.frontier->against, &Axis::name);
  const auto largest = std::ranges::find(spec.axes, spec.frontier->largest, &Axis::name);
  chart.x_log = spans_much(*against);
  chart.y_log = spans_much(*largest);
  return chart;
}

/// Texts of the values of an axis by ascending number.
std::vector<std::string> ascending(const sweep::SweepSpec& spec, const std::string& name) {
  const auto axis = std::ranges::find(spec.axes, name, &Axis::name);
  std::vector<sweep::Setting> values = axis->values;
  std::ranges::stable_sort(values, {}, [](const sweep::Setting& value) { return value.number.value_or(0); });
  std::vector<std::string> texts;
  for (const sweep::Setting& value : values) texts.push_back(value.text);
  return texts;
}

/// One map for each combination of scene and other axes, of the first figure of the requirements.
std::vector<DrawnPicture> heat_maps(const sweep::SweepSpec& spec, const sweep::Results& results,
                                    const std::vector<Group>& groups) {
  std::vector<DrawnPicture> pictures;
  const io::Requirement requirement = sweep::requirement_of(spec);
  if (!spec.frontier || requirement.empty()) return pictures;
  const auto& [largest, against] = *spec.frontier;
  const std::string figure =
      requirement.front().left.name.empty() ? requirement.front().right.name : requirement.front().left.name;
  const std::optional<std::size_t> at = index_of(results, figure);
  if (!at) return pictures;
  std::vector<std::pair<std::string, HeatMap>> maps;
  for (const Group& group : groups) {
    const std::string label = sweep::group_label(spec, group, {largest, against});
    auto entry = std::ranges::find(maps, label, [](const auto& map) { return map.first; });
    if (entry == maps.end()) {
      HeatMap map{fmt::format("{}: {}", figure, label),
                  against,
                  largest,
                  ascending(spec, against),
                  ascending(spec, largest),
                  {}};
      map.cells.resize(map.x.size() * map.y.size());
      entry = maps.insert(maps.end(), {label, std::move(map)});
    }
    HeatMap& map = entry->second;
    const auto x = std::ranges::find(map.x, sweep::value_of(group, against)) - map.x.begin();
    const auto y = std::ranges::find(map.y, sweep::value_of(group, largest)) - map.y.begin();
    map.cells[static_cast<std::size_t>(y) * map.x.size() + static_cast<std::size_t>(x)] = {group.mean[*at],
                                                                                           group.holds};
  }
  for (const auto& [label, map] : maps) pictures.push_back({map.title, "image/svg+xml", heat_map_svg(map)});
  if (pictures.size() > kMostCharts) pictures.resize(kMostCharts);
  return pictures;
}

std::string figure_text(const std::optional<double>& value) { return value ? fmt::format("{:.4g}", *value) : "-"; }

/// A row for each group.
std::string group_table(const sweep::SweepSpec& spec, const sweep::Results& results, const std::vector<Group>& groups) {
  const std::vector<std::string> figures = shown_figures(spec, results);
  std::string head = "| scene |", rule = "|---|";
  const auto add_column = [&](const std::string& name) {
    head += " " + name + " |";
    rule += "---|";
  };
  for (const Axis& axis : spec.axes) {
    if (varies(axis)) add_column(axis.name);
  }
  for (const std::string& figure : figures) add_column(figure);
  if (!spec.requirements.empty()) add_column("holds");
  add_column("trials");
  std::string text = head + "\n" + rule + "\n";
  for (std::size_t i = 0; i < std::min(groups.size(), kMostTableRows); ++i) {
    const Group& group = groups[i];
    text += "| " + group.scene + " |";
    for (const Axis& axis : spec.axes) {
      if (varies(axis)) text += " " + sweep::value_of(group, axis.name) + " |";
    }
    for (const std::string& figure : figures) {
      const std::optional<std::size_t> at = index_of(results, figure);
      text += " " + figure_text(at ? group.mean[*at] : std::nullopt) + " |";
    }
    if (!spec.requirements.empty()) text += group.holds ? (*group.holds ? " yes |" : " no |") : " - |";
    text += fmt::format(" {} of {} |\n", group.done, group.done + group.ended + group.pending);
  }
  if (groups.size() > kMostTableRows)
    text += fmt::format("\n{} rows more in trials.csv.\n", groups.size() - kMostTableRows);
  return text;
}

std::string comma_list(const std::vector<std::string>& texts) { return fmt::format("{}", fmt::join(texts, ", ")); }

}  // namespace

std::string picture_name(const std::string& text) {
  std::string name;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (plain) {
      name += c;
    } else if (!name.empty() && name.back() != '-') {
      name += '-';
    }
  }
  while (!name.empty() && name.back() == '-') name.pop_back();
  return name;
}

FiguresDocument sweep_figures(const sweep::SweepSpec& spec, const sweep::Results& results,
                              const std::vector<Group>& groups, std::vector<std::string> command) {
  FiguresDocument page;
  const sweep::StateCounts counts = sweep::count_states(results);
  page.title = spec.name;
  const auto ending = [](std::size_t count) { return count == 1 ? "" : "s"; };
  page.subtitle = fmt::format("{} trial{} · {} scene{} · {} combination{} of settings", results.trials.size(),
                              ending(results.trials.size()), spec.scenes.size(), ending(spec.scenes.size()),
                              groups.size(), ending(groups.size()));
  const std::vector<sweep::FrontierLine> frontier = sweep::frontier_of(spec, groups);
  page.headline = fmt::format("{} of {} trials are done", counts.done, results.trials.size());
  page.headline_text = fmt::format("{} failed, {} were ended at their time limit, {} are pending", counts.failed,
                                   counts.timed_out, counts.pending);
  const std::string holds = holds_text(groups);
  page.headline_text += holds.empty() ? "." : fmt::format("; {}.", holds);
  if (counts.failed + counts.timed_out > 0) page.mark = FiguresDocument::Mark::Bad;
  if (std::optional<LineChart> chart = frontier_chart(spec, frontier)) page.charts.push_back(std::move(*chart));
  std::size_t left_out = 0;
  for (const Axis& axis : spec.axes) {
    if (!varies(axis) || !has_numbers(axis)) continue;
    for (const std::string& figure : shown_figures(spec, results)) {
      const std::optional<std::size_t> at = index_of(results, figure);
      if (!at) continue;
      for (LineChart& chart : charts_along(spec, groups, axis, figure, *at)) {
        if (page.charts.size() < kMostCharts) {
          page.charts.push_back(std::move(chart));
        } else {
          ++left_out;
        }
      }
    }
  }
  page.pictures = heat_maps(spec, results, groups);
  page.tables = frontier_table(spec, frontier);
  if (!page.tables.empty()) page.tables += "\n";
  page.tables += group_table(spec, results, groups);
  if (left_out > 0) page.tables += fmt::format("\n{} more curves were left out.\n", left_out);
  page.command = std::move(command);
  page.settings = {{"scenes", comma_list(spec.scenes)}, {"repeats", std::to_string(spec.repeats)}};
  for (const sweep::Setting& setting : spec.settings) page.settings.emplace_back(setting.name, setting.text);
  if (!spec.requirements.empty()) page.settings.emplace_back("requirements", comma_list(spec.requirements));
  page.machine = io::this_machine();
  page.build = io::this_build();
  return page;
}

}  // namespace poise::app
