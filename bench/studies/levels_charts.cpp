// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "studies/levels_document.h"

namespace poise::io {
namespace {

// A smaller error is drawn as this one: it is below what the oracle itself knows.
constexpr double kLeastPlotted = 0.001;

// Positions on the axis: the levels of trees, then the polygons.
double place_of(simulation::ProbeLevel level, int deepest) {
  return level.polygons ? deepest + 1 : static_cast<double>(level.level);
}

app::ChartLine& line_of(app::LineChart& chart, const std::string& label) {
  const auto found = std::ranges::find(chart.lines, label, &app::ChartLine::label);
  if (found != chart.lines.end()) return *found;
  return chart.lines.emplace_back(app::ChartLine{label, {}});
}

// Of all pairs of a group.
double uncertainty_of(const LevelsDocument& document, const std::string& group) {
  double sum = 0;
  double pairs = 0;
  for (const LevelsPair& pair : document.pairs) {
    if (pair.group != group) continue;
    sum += pair.uncertainty;
    ++pairs;
  }
  return pairs > 0 ? sum / pairs : 0;
}

app::LineChart panel_of(const LevelsDocument& document, const LevelsSummary& first, int deepest) {
  app::LineChart panel{first.group,
                       fmt::format("{}, {} {} of shapes: mean error of dv", first.group, first.pairs,
                                   first.pairs == 1 ? "pair" : "pairs"),
                       "Dots: what is to be reached.",
                       "level",
                       {},
                       {{"oracle, 1 mm", std::max(uncertainty_of(document, first.group), kLeastPlotted), {}}}};
  panel.y_log = true;
  for (int level = 0; level <= deepest; ++level) panel.x_names.push_back(std::to_string(level));
  return panel;
}

}  // namespace

std::vector<app::LineChart> levels_charts(const LevelsDocument& document) {
  const std::vector<LevelsSummary> all = summaries(document);
  const bool polygons = std::ranges::any_of(all, [](const LevelsSummary& s) { return s.level.polygons; });
  int deepest = 0;
  for (const LevelsSummary& s : all) deepest = std::max(deepest, s.level.polygons ? 0 : int{s.level.level});
  std::vector<app::LineChart> panels;
  for (const LevelsSummary& s : all) {
    if (panels.empty() || panels.back().id != s.group) {
      panels.push_back(panel_of(document, s, deepest));
      if (polygons) panels.back().x_names.emplace_back("polygons");
    }
    line_of(panels.back(), s.model)
        .points.push_back({place_of(s.level, deepest), std::max(s.dv.mean, kLeastPlotted), {}, {}});
  }
  // After the models, so that a model has the same colour in all panels. The first model has the targets of all.
  for (app::LineChart& panel : panels) {
    const std::string model = panel.lines.front().label;
    app::ChartLine targets{"to reach", {}, app::LineMarks::Dots};
    for (const LevelsSummary& s : all) {
      if (s.group == panel.id && s.model == model && s.target)
        targets.points.push_back({place_of(s.level, deepest), *s.target, {}, {}});
    }
    if (!targets.points.empty()) panel.lines.push_back(std::move(targets));
    for (app::ChartLine& line : panel.lines) std::ranges::sort(line.points, {}, &app::LinePoint::x);
  }
  return panels;
}

}  // namespace poise::io
