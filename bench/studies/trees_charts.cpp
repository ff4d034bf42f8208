// SPDX-License-Identifier: MIT
#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scene/run/percentiles.h"
#include "studies/study_charts.h"
#include "studies/trees_document.h"

namespace poise::io {
namespace {

// The mean protrusion of all meshes at each level, a line a preset.
app::LineChart fit_chart(const TreesDocument& document) {
  app::LineChart chart{"fit",
                       "mean protrusion, % of the diagonal",
                       "The median of the meshes; bands: from the least to the largest.",
                       "level",
                       {}};
  chart.y_log = true;
  std::map<std::string, std::map<int, std::vector<double>>> of_presets;
  for (const TreesRow& row : document.rows) {
    if (!row.refusal.empty()) continue;
    for (const TreeLevelFigures& figures : row.tree.levels)
      of_presets[preset_name(row.tree.preset)][figures.level].push_back(100 * figures.protrusion_mean_m /
                                                                        row.diagonal_m);
  }
  std::set<int> levels;
  for (const auto& [preset, of_levels] : of_presets) {
    app::ChartLine& line = chart.lines.emplace_back(app::ChartLine{preset, {}});
    for (const auto& [level, values] : of_levels) {
      levels.insert(level);
      line.points.push_back({static_cast<double>(level), simulation::percentile(values, 0.5),
                             *std::ranges::min_element(values), *std::ranges::max_element(values)});
    }
  }
  for (int level = 0; !levels.empty() && level <= *levels.rbegin(); ++level)
    chart.x_names.push_back(std::to_string(level));
  return chart;
}

app::LineChart cost_chart(const TreesDocument& document) {
  app::LineChart chart{"cost", "CPU time of a build, s", "", "triangles of the mesh", {}, {}, true, true};
  std::map<std::string, std::vector<app::LinePoint>> of_presets;
  for (const TreesRow& row : document.rows) {
    if (!row.refusal.empty() || !row.tree.cost) continue;
    of_presets[preset_name(row.tree.preset)].push_back(
        {static_cast<double>(row.triangles), row.tree.cost->cpu_ms / 1000, {}, {}});
  }
  const app::LineMarks marks = document.study == "scaling" ? app::LineMarks::LineAndDots : app::LineMarks::Dots;
  for (auto& [preset, points] : of_presets) {
    std::ranges::sort(points, {}, &app::LinePoint::x);
    chart.lines.push_back({preset, std::move(points), marks});
  }
  return chart;
}

}  // namespace

std::vector<app::LineChart> trees_charts(const TreesDocument& document) {
  std::vector<app::LineChart> charts{fit_chart(document), cost_chart(document)};
  app::leave_out_empty(charts);
  return charts;
}

}  // namespace poise::io
