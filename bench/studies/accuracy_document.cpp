// SPDX-License-Identifier: MIT
#include "studies/accuracy_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>
#include <utility>

#include "studies/study_charts.h"

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;
using Cells = std::vector<std::string>;

// The smallest value on the logarithmic axes.
constexpr double kLeast = 1e-12;
// A figure that is a smaller share of its bound is drawn here.
constexpr double kLeastOfBound = 1e-6;

std::string bound_text(const AccuracyRow& row) {
  return row.at_most ? fmt::format("{:.4g}", *row.at_most) : std::string("-");
}
std::string report(const AccuracyRow& row) { return !row.ok ? "missed" : row.at_most ? "ok" : "-"; }

// A case name is printed once, above its rows.
std::vector<Cells> cells_of(const AccuracyDocument& document) {
  std::vector<Cells> table{{"case", "figure", "unit", "value", "at most", "published", "ok"}};
  std::string before;
  for (const AccuracyRow& row : document.rows) {
    table.push_back({row.case_name == before ? "" : row.case_name, row.figure, row.unit,
                     fmt::format("{:.4g}", row.value), bound_text(row), row.published, report(row)});
    before = row.case_name;
  }
  return table;
}

std::string made_by(const AccuracyDocument& d) {
  return fmt::format(
      "{} of {} rows missed; {:.0f} s of CPU time, {} threads; {}, {} cores, {}; poise {} commit {}, {}, {}\n",
      missed(d), d.rows.size(), d.cpu_s, d.threads, d.machine.processor, d.machine.cores, d.machine.system,
      d.build.version, d.build.commit, d.build.compiler, d.build.flags);
}

}  // namespace

std::size_t missed(const AccuracyDocument& document) {
  return static_cast<std::size_t>(
      std::count_if(document.rows.begin(), document.rows.end(), [](const AccuracyRow& row) { return !row.ok; }));
}

std::string accuracy_json(const AccuracyDocument& document) {
  Json json;
  json["schema"] = "poise.accuracy/1";
  json["rows"] = Json::array();
  for (const AccuracyRow& row : document.rows) {
    json["rows"].push_back({{"case", row.case_name},
                            {"figure", row.figure},
                            {"unit", row.unit},
                            {"value", row.value},
                            {"at_most", row.at_most ? Json(*row.at_most) : Json(nullptr)},
                            {"published", row.published.empty() ? Json(nullptr) : Json(row.published)},
                            {"ok", row.ok}});
  }
  json["missed"] = missed(document);
  json["series"] = Json::array();
  for (const AccuracySeries& series : document.series) {
    json["series"].push_back({{"case", series.case_name},
                              {"time_s", series.time_s},
                              {"drift_m", series.drift_m},
                              {"kinetic_j", series.kinetic_j}});
  }
  json["threads"] = document.threads;
  json["cpu_s"] = document.cpu_s;
  json["machine"] = document.machine;
  json["build"] = document.build;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string accuracy_table(const AccuracyDocument& document) {
  const std::vector<Cells> table = cells_of(document);
  std::vector<std::size_t> widths(table[0].size());
  for (const Cells& row : table) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text;
  for (const Cells& row : table) {
    text +=
        fmt::format("{:<{}}  {:<{}}  {:<{}}  {:>{}}  {:>{}}  {:<6}{}{}\n", row[0], widths[0], row[1], widths[1], row[2],
                    widths[2], row[3], widths[3], row[4], widths[4], row[6], row[5].empty() ? "" : "  ", row[5]);
  }
  return text + "\n" + made_by(document);
}

std::string accuracy_markdown(const AccuracyDocument& document) {
  std::string text;
  bool head = true;
  for (const Cells& row : cells_of(document)) {
    text += fmt::format("| {} |\n", fmt::join(row, " | "));
    if (head) text += "|---|---|---|---|---|---|---|\n";
    head = false;
  }
  return text + "\n" + made_by(document);
}

std::vector<app::LineChart> accuracy_charts(const AccuracyDocument& document) {
  std::vector<app::LineChart> charts;
  for (const auto& [id, title, values] : {std::tuple("drift", "largest drift, m", &AccuracySeries::drift_m),
                                          std::tuple("energy", "kinetic energy, J", &AccuracySeries::kinetic_j)}) {
    app::LineChart& chart = charts.emplace_back(app::LineChart{id, title, "Of what stands, over 60 s.", "time, s", {}});
    chart.y_log = true;
    for (const AccuracySeries& series : document.series) {
      app::ChartLine& line = chart.lines.emplace_back(app::ChartLine{series.case_name, {}, app::LineMarks::Line});
      for (std::size_t k = 0; k < series.time_s.size(); ++k) {
        // What has no place on a logarithmic axis is a gap of its line, not a line along the axis.
        const double value = (series.*values)[k];
        line.points.push_back({series.time_s[k], value > kLeast ? value : std::nan(""), {}, {}});
      }
    }
  }
  return charts;
}

app::LineChart bounds_chart(const AccuracyDocument& document) {
  app::LineChart chart{
      "bounds",          "largest figure of a case / its bound", "Below the line is accurate enough.", "case", {},
      {{"bound", 1, {}}}};
  chart.y_log = true;
  app::ChartLine line{"figure", {}, app::LineMarks::Dots};
  std::vector<std::string> names;
  for (const AccuracyRow& row : document.rows) {
    if (names.empty() || names.back() != row.case_name) {
      names.push_back(row.case_name);
      line.points.push_back({static_cast<double>(names.size() - 1), std::nan(""), {}, {}});
    }
    if (!row.at_most || !(*row.at_most > 0)) continue;
    const double share = std::max(row.value / *row.at_most, kLeastOfBound);
    line.points.back().y = std::fmax(line.points.back().y, share);  // a NaN gives way
  }
  chart.lines.push_back(std::move(line));
  app::name_places(chart, std::move(names), "cases");
  return chart;
}

}  // namespace poise::io
