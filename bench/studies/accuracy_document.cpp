// SPDX-License-Identifier: MIT
#include "studies/accuracy_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

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

std::string accuracy_plot(const AccuracyDocument& document) {
  if (document.series.empty()) return "";
  std::string text =
      "set terminal pngcairo size 1400,640 font \"sans,13\"\nset logscale y\nset format y \"10^{%L}\"\nset grid xtics "
      "ytics lt 1 lw 1 lc rgb \"#cccccc\"\n"
      "set linetype 9 lc rgb \"#888888\"\nset key outside below maxrows 5\nset xlabel \"time in s\"\n";
  for (std::size_t i = 0; i < document.series.size(); ++i) {
    const AccuracySeries& series = document.series[i];
    text += fmt::format("$case{} << EOD\n", i);
    for (std::size_t k = 0; k < series.time_s.size(); ++k) {
      text += fmt::format("{:g} {:g} {:g}\n", series.time_s[k], std::max(series.drift_m[k], kLeast),
                          std::max(series.kinetic_j[k], kLeast));
    }
    text += "EOD\n";
  }
  text += "set multiplot layout 1,2\n";
  for (const auto& [column, title] : {std::pair{2, "largest drift in m"}, std::pair{3, "kinetic energy in J"}}) {
    text += fmt::format("set title \"{}\"\nplot ", title);
    for (std::size_t i = 0; i < document.series.size(); ++i) {
      text += fmt::format("{}$case{} using 1:{} with lines lw 2 title \"{}\"", i == 0 ? "" : ", ", i, column,
                          document.series[i].case_name);
    }
    text += "\n";
  }
  return text + "unset multiplot\n";
}

}  // namespace poise::io
