// SPDX-License-Identifier: MIT
#include "app/compare/compare_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>

namespace poise::app {
namespace {

using Row = io::ComparisonRow;

std::string budget_label(const io::ComparisonDocument& document) {
  if (document.budget_unit == "percent") return "budget of a frame, % of the work of full refinement";
  if (document.budget_unit == "ms") return "budget of a frame, ms";
  return "budget of a frame, work units";
}

LinePoint with_interval(double budget, const io::Estimate& estimate) {
  return {budget, estimate.mean, estimate.low, estimate.high};
}

/// One chart: a line for each policy that has a value.
LineChart chart_of(const io::ComparisonDocument& document, std::string id, std::string title, std::string note,
                   const std::function<std::optional<LinePoint>(const Row&)>& value) {
  LineChart chart;
  chart.id = std::move(id);
  chart.title = std::move(title);
  chart.note = std::move(note);
  chart.x_label = budget_label(document);
  for (const Row& row : document.result.rows) {
    const std::optional<LinePoint> point = value(row);
    if (!point) continue;
    if (chart.lines.empty() || chart.lines.back().label != row.policy) chart.lines.push_back({row.policy, {}, {}});
    chart.lines.back().points.push_back(*point);
  }
  return chart;
}

LineChart e_seen_chart(const io::ComparisonDocument& d, std::string title, std::string note) {
  return chart_of(d, "e-seen", std::move(title), std::move(note),
                  [](const Row& row) { return with_interval(row.budget, row.e_seen_mps); });
}

std::vector<LineChart> charts_of(const io::ComparisonDocument& d) {
  // One state has no interval.
  const char* const bands =
      d.result.frames > 1 ? "Lower is better. Bands: 95 % intervals of the mean." : "Lower is better.";
  std::vector<LineChart> charts;
  charts.push_back(e_seen_chart(d, "E_seen: error that a viewer notices, m/s", bands));
  charts.push_back(chart_of(d, "e-rel", "E_rel: error as a share of what the frame changes", bands,
                            [](const Row& row) { return with_interval(row.budget, row.e_rel); }));
  charts.push_back(chart_of(d, "e", "E: error of all bodies alike, m/s", bands,
                            [](const Row& row) { return with_interval(row.budget, row.e_mps); }));
  charts.push_back(chart_of(d, "regret", "Regret: E_seen above that of the oracle, m/s",
                            "What a perfect order would still gain. Without the oracle's own line, which is 0.",
                            [](const Row& row) -> std::optional<LinePoint> {
                              if (!row.regret_mps || row.policy == io::kOraclePolicy) return {};
                              return LinePoint{row.budget, *row.regret_mps, {}, {}};
                            }));
  std::erase_if(charts, [](const LineChart& chart) { return chart.lines.empty(); });
  return charts;
}

std::string shown(const std::optional<double>& value, double factor = 1) {
  return value ? fmt::format("{:.3g}", factor * *value) : "-";
}

std::string interval(const io::Estimate& estimate) {
  if (!estimate.low || !estimate.high) return "-";
  return fmt::format("{:.4g} to {:.4g}", *estimate.low, *estimate.high);
}

std::string tables_of(const io::ComparisonDocument& d) {
  std::string text = fmt::format(
      "| policy | budget, {} | E_seen, m/s | 95 % interval | regret | E_rel | E, m/s | gap, px | false % | work units "
      "| step, ms |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
      d.budget_unit == "percent" ? "%"
      : d.budget_unit == "ms"    ? "ms"
                                 : "work units");
  for (const Row& row : d.result.rows) {
    text +=
        fmt::format("| {} | {:g} | {:.4g} | {} | {} | {:.3g} | {:.4g} | {} | {} | {:.0f} | {:.3g} |\n", row.policy,
                    row.budget, row.e_seen_mps.mean, interval(row.e_seen_mps), shown(row.regret_mps), row.e_rel.mean,
                    row.e_mps.mean, shown(row.gap_mean_px), shown(row.false_rate, 100), row.work_units, row.time_ms);
  }
  if (d.result.budgets.size() > 1) {
    text +=
        "\nMean over the budgets: the mean height of the curve of E_seen.\n\n| policy | E_seen, m/s | 95 % interval "
        "| regret |\n|---|---|---|---|\n";
    for (const io::ComparisonArea& area : d.result.areas) {
      text += fmt::format("| {} | {:.4g} | {} | {} |\n", area.policy, area.e_seen_mps.mean, interval(area.e_seen_mps),
                          shown(area.regret_mps));
    }
  }
  return text;
}

std::string frames_text(const io::PolicyComparison& result) {
  std::string text = fmt::format("{}", result.frames);
  if (result.not_converged > 0) text += fmt::format("; {} left out: no converged reference", result.not_converged);
  if (result.undefined > 0) text += fmt::format("; {} left out: nothing touched", result.undefined);
  return text;
}

}  // namespace

FiguresDocument comparison_figures(const io::ComparisonDocument& d, std::vector<std::string> command) {
  FiguresDocument page;
  page.title = d.scene + ": policies compared";
  page.subtitle = fmt::format("{} bodies · {} states, each stepped by {} policies with {} budgets", d.bodies,
                              d.result.frames, d.result.areas.size(), d.result.budgets.size());
  page.mark = d.result.sure ? FiguresDocument::Mark::Good : FiguresDocument::Mark::None;
  if (d.result.best.empty()) {
    page.headline = "No policy to tell of";
  } else if (d.result.next.empty()) {
    page.headline = d.result.best + ", compared with nothing";
  } else if (d.result.sure) {
    page.headline = d.result.best + " leaves the least to be seen";
  } else if (d.result.too_few) {
    page.headline = fmt::format("Too few states to tell {} from {}", d.result.best, d.result.next);
  } else {
    page.headline = fmt::format("{} and {} cannot be told apart", d.result.best, d.result.next);
  }
  page.headline_text = d.result.conclusion;
  page.charts = charts_of(d);
  page.tables = tables_of(d);
  page.command = std::move(command);
  page.settings = {{"states compared", frames_text(d.result)},
                   {"clock", d.clock},
                   {"frames that each policy steps", std::to_string(d.history)},
                   {"seed", std::to_string(d.seed)}};
  page.machine = d.machine;
  page.build = d.build;
  return page;
}

std::string comparison_svg(const io::ComparisonDocument& d) {
  return line_chart_svg(e_seen_chart(d, fmt::format("{}, {} frames: E_seen, m/s", d.scene, d.result.frames), {}));
}

}  // namespace poise::app
