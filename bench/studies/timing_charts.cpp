// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "studies/study_charts.h"
#include "studies/timing_document.h"

namespace poise::io {
namespace {

app::ChartLine& line_of(app::LineChart& chart, const std::string& label, app::LineMarks marks) {
  const auto found = std::ranges::find(chart.lines, label, &app::ChartLine::label);
  if (found != chart.lines.end()) return *found;
  return chart.lines.emplace_back(app::ChartLine{label, {}, marks});
}

// The place of a name among those so far.
double place_of(std::vector<std::string>& names, const std::string& name) {
  auto found = std::ranges::find(names, name);
  if (found == names.end()) found = names.insert(names.end(), name);
  return static_cast<double>(found - names.begin());
}

const char* state_name(bool settled) { return settled ? "settled" : "falling"; }

}  // namespace

std::vector<app::LineChart> cost_charts(const CostDocument& document) {
  std::vector<app::LineChart> charts;
  for (const bool settled : {false, true}) {
    app::LineChart& chart = charts.emplace_back(app::LineChart{state_name(settled),
                                                               fmt::format("{}: ns a body", state_name(settled)),
                                                               "Each mandatory stage; the median of frames.",
                                                               "bodies",
                                                               {},
                                                               {},
                                                               true,
                                                               true});
    for (const CostRow& row : document.rows) {
      if (row.settled != settled) continue;
      line_of(chart, row.stage, app::LineMarks::LineAndDots)
          .points.push_back({static_cast<double>(row.bodies), row.ns_per_body(), {}, {}});
    }
    for (app::ChartLine& line : chart.lines) std::ranges::sort(line.points, {}, &app::LinePoint::x);
  }
  app::leave_out_empty(charts);
  return charts;
}

std::vector<app::LineChart> cache_charts(const CacheDocument& document) {
  app::LineChart chart{"stages", "time of a stage, ms", "Medians of frames.", "stage", {}};
  app::ChartLine cached{"with the contact cache", {}, app::LineMarks::Dots};
  app::ChartLine anew{"without", {}, app::LineMarks::Dots};
  std::vector<std::string> names;
  for (const CacheRow& row : document.rows) {
    const double place = place_of(names, row.stage);
    cached.points.push_back({place, row.cached_ms, {}, {}});
    anew.points.push_back({place, row.anew_ms, {}, {}});
  }
  chart.lines = {std::move(cached), std::move(anew)};
  app::name_places(chart, std::move(names), "stages");
  return {std::move(chart)};
}

std::vector<app::LineChart> scaling_charts(const ScalingDocument& document) {
  app::LineChart chart{"scaling",
                       "node-pair expansions a microsecond",
                       "Medians of frames; bands: from 10 to 90 % of them.",
                       "threads",
                       {}};
  app::ChartLine line{"refinement", {}};
  for (const ScalingRow& row : document.rows)
    line.points.push_back({static_cast<double>(row.threads), row.units_per_us, row.p10, row.p90});
  std::ranges::sort(line.points, {}, &app::LinePoint::x);
  chart.lines.push_back(std::move(line));
  return {std::move(chart)};
}

std::vector<app::LineChart> span_charts(const SpanDocument& document) {
  app::LineChart chart{"span",
                       fmt::format("work / time on {} cores", document.cores),
                       "By how much a stage can be faster at most.",
                       "stage",
                       {}};
  std::vector<std::string> names;
  for (const SpanRow& row : document.rows) {
    line_of(chart, state_name(row.settled), app::LineMarks::Dots)
        .points.push_back({place_of(names, row.stage), row.times_faster(), {}, {}});
  }
  app::name_places(chart, std::move(names), "stages");
  return {std::move(chart)};
}

std::vector<app::LineChart> free_charts(const FreeDocument& document) {
  app::LineChart chart{"instructions", "instructions of a step, on / off", "", "feature", {}, {{"the same", 1, {}}}};
  chart.y_from_data = true;
  app::ChartLine line{"on / off", {}, app::LineMarks::Dots};
  std::vector<std::string> names;
  for (const FreeRow& row : document.rows) {
    if (row.absent || !(row.off_instructions > 0)) continue;
    line.points.push_back({place_of(names, row.feature), row.on_instructions / row.off_instructions, {}, {}});
  }
  chart.lines.push_back(std::move(line));
  app::name_places(chart, std::move(names), "features");
  std::vector<app::LineChart> charts{std::move(chart)};
  app::leave_out_empty(charts);
  return charts;
}

}  // namespace poise::io
