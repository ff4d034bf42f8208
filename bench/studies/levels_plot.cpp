// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>

#include "studies/gnuplot.h"
#include "studies/levels_document.h"

namespace poise::io {
namespace {

constexpr double kLeastPlotted = 0.001;

// Positions on the axis: the levels of trees, then the polygons.
int place_of(simulation::ProbeLevel level) { return level.polygons ? kMaxTreeDepth + 1 : level.level; }

struct Panel {
  std::string group;
  std::vector<std::string> models;
  std::size_t pairs = 0;
  double uncertainty = 0;
  bool targets = false;
};

std::vector<Panel> panels_of(const LevelsDocument& document, const std::vector<LevelsSummary>& all) {
  std::vector<Panel> panels;
  for (const LevelsSummary& s : all) {
    if (panels.empty() || panels.back().group != s.group) panels.push_back({s.group, {}, s.pairs, 0, false});
    Panel& panel = panels.back();
    if (std::find(panel.models.begin(), panel.models.end(), s.model) == panel.models.end())
      panel.models.push_back(s.model);
    panel.targets = panel.targets || s.target;
  }
  for (Panel& panel : panels) {
    for (const LevelsPair& pair : document.pairs) {
      if (pair.group == panel.group) panel.uncertainty += pair.uncertainty / static_cast<double>(panel.pairs);
    }
  }
  return panels;
}

// Polygons are drawn to the right of the deepest level.
int shown(int place, int deepest) { return place > kMaxTreeDepth ? deepest + 1 : place; }

std::string tics(const std::vector<LevelsSummary>& all, int deepest) {
  std::string text;
  for (int level = 0; level <= deepest; ++level)
    text += fmt::format("{}\"{}\" {}", level == 0 ? "" : ", ", level, level);
  if (std::any_of(all.begin(), all.end(), [](const LevelsSummary& s) { return s.level.polygons; })) {
    text += fmt::format(", \"polygons\" {}", deepest + 1);
  }
  return text;
}

}  // namespace

std::string levels_plot(const LevelsDocument& document) {
  const std::vector<LevelsSummary> all = summaries(document);
  const std::vector<Panel> panels = panels_of(document, all);
  const bool polygons = std::any_of(all.begin(), all.end(), [](const LevelsSummary& s) { return s.level.polygons; });
  int deepest = 0;
  for (const LevelsSummary& s : all) deepest = std::max(deepest, s.level.polygons ? 0 : int{s.level.level});
  std::string text = app::plot_style(700 * std::max<std::size_t>(panels.size(), 1), 640) +
                     fmt::format("set multiplot layout 1,{}\n", std::max<std::size_t>(panels.size(), 1));
  text += fmt::format(
      "set logscale y\nset yrange [{}:2]\nset xrange [-0.3:{:g}]\nset xtics ({})\n"
      "set xlabel \"level\"\nset ylabel \"mean error of dv\"\n",
      kLeastPlotted, deepest + (polygons ? 1.3 : 0.3), tics(all, deepest));
  for (const Panel& panel : panels) {
    text += fmt::format("set title \"{}: {} pairs of shapes\"\n", panel.group, panel.pairs);
    std::string data;
    std::string plots;
    for (std::size_t i = 0; i < panel.models.size(); ++i) {
      data += fmt::format("$model{} << EOD\n", i);
      for (const LevelsSummary& s : all) {
        if (s.group != panel.group || s.model != panel.models[i]) continue;
        data += fmt::format("{} {:g}\n", shown(place_of(s.level), deepest), std::max(s.dv.mean, kLeastPlotted));
      }
      data += "EOD\n";
      plots += fmt::format("$model{0} using 1:2 with linespoints title \"{1}\", ", i, panel.models[i]);
    }
    if (panel.targets) {
      data += "$target << EOD\n";
      for (const LevelsSummary& s : all) {
        if (s.group == panel.group && s.model == panel.models[0] && s.target)
          data += fmt::format("{} {:g}\n", shown(place_of(s.level), deepest), *s.target);
      }
      data += "EOD\n";
      plots += "$target using 1:2 with points pt 2 ps 2 lc rgb \"black\" title \"to reach\", ";
    }
    plots += fmt::format("{:g} with lines dt 2 lc rgb \"#888888\" title \"the oracle's own uncertainty (1 mm)\"",
                         std::max(panel.uncertainty, kLeastPlotted));
    text += data + "plot " + plots + "\n";
  }
  return text + "unset multiplot\n";
}

}  // namespace poise::io
