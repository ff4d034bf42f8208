// SPDX-License-Identifier: MIT
#include "studies/accuracy_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "studies/gnuplot.h"

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;
using Cells = std::vector<std::string>;

// The smallest value on the logarithmic axes.
constexpr double kLeast = 1e-12;

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

namespace {
/// What has no place on a logarithmic axis is a gap of its line, not a line along the axis.
std::string shown(double value) { return value > kLeast ? fmt::format("{:g}", value) : std::string("NaN"); }

/// The axis for what is shown of all cases: gnuplot finds none by itself where nothing is.
std::string range_of(const std::vector<AccuracySeries>& all, std::vector<double> AccuracySeries::*values) {
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  for (const AccuracySeries& series : all) {
    for (const double value : series.*values) {
      if (!(value > kLeast) || !std::isfinite(value)) continue;
      least = std::min(least, value);
      most = std::max(most, value);
    }
  }
  return most > 0 ? fmt::format("{:g}:{:g}", 0.5 * least, 2 * most) : fmt::format("{:g}:1", kLeast);
}
}  // namespace

std::string accuracy_plot(const AccuracyDocument& document) {
  if (document.series.empty()) return "";
  std::string text = app::plot_style(1400, 640) +
                     "set logscale y\nset format y \"10^{%L}\"\nset key maxrows 5\nset xlabel \"time in s\"\n";
  for (std::size_t i = 0; i < document.series.size(); ++i) {
    const AccuracySeries& series = document.series[i];
    text += fmt::format("$case{} << EOD\n", i);
    for (std::size_t k = 0; k < series.time_s.size(); ++k) {
      text += fmt::format("{:g} {} {}\n", series.time_s[k], shown(series.drift_m[k]), shown(series.kinetic_j[k]));
    }
    text += "EOD\n";
  }
  text += "set multiplot layout 1,2\n";
  for (const auto& [column, title] : {std::pair{2, "largest drift in m"}, std::pair{3, "kinetic energy in J"}}) {
    text += fmt::format("set title \"{}\"\nset yrange [{}]\nplot ", title,
                        range_of(document.series, column == 2 ? &AccuracySeries::drift_m : &AccuracySeries::kinetic_j));
    for (std::size_t i = 0; i < document.series.size(); ++i) {
      text += fmt::format("{}$case{} using 1:{} with lines title \"{}\"", i == 0 ? "" : ", ", i, column,
                          document.series[i].case_name);
    }
    text += "\n";
  }
  return text + "unset multiplot\n";
}

}  // namespace poise::io
