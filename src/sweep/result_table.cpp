// SPDX-License-Identifier: MIT
#include "sweep/result_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "scene/csv_text.h"

namespace poise::sweep {
namespace {

std::vector<std::string> setting_names(const SweepSpec& spec) {
  std::vector<std::string> names;
  for (const Setting& setting : spec.settings) names.push_back(setting.name);
  for (const Axis& axis : spec.axes) names.push_back(axis.name);
  return names;
}

Cell cell_of(const Trial& trial, const std::string& name) {
  const auto setting = std::ranges::find(trial.settings, name, &Setting::name);
  if (setting == trial.settings.end()) return {};
  // A whole number that a double cannot hold, such as a seed, stays as it is written.
  if (setting->number && fmt::format("{}", *setting->number) == setting->text) return *setting->number;
  return setting->text;
}

Cell text_cell(const std::string& text) { return text.empty() ? Cell() : Cell(text); }

std::string csv_cell(const Cell& cell) {
  if (const double* number = std::get_if<double>(&cell)) return fmt::format("{}", *number);
  const std::string* text = std::get_if<std::string>(&cell);
  return text == nullptr ? std::string() : io::csv_text(*text);
}

}  // namespace

std::vector<std::string> result_columns(const SweepSpec& spec, const Results& results) {
  std::vector<std::string> columns{"trial", "scene"};
  for (const std::string& name : setting_names(spec)) columns.push_back(name);
  columns.insert(columns.end(), {"repeat", "state", "exit_code", "seconds", "host", "engine", "cores",
                                 "requirements_hold", "state_hash", "processor", "commit"});
  for (const std::string& name : results.figures)
    columns.push_back(name.find('.') == std::string::npos ? "run." + name : name);
  return columns;
}

std::vector<Cell> result_row(const SweepSpec& spec, const Results& results, const TrialResult& result) {
  std::vector<Cell> row{result.trial.key, result.trial.scene};
  for (const std::string& name : setting_names(spec)) row.push_back(cell_of(result.trial, name));
  const Outcome& outcome = result.outcome;
  const bool ended = outcome.state != TrialState::Pending;
  row.emplace_back(static_cast<double>(result.trial.repeat));
  row.emplace_back(std::string(state_name(outcome.state)));
  row.push_back(ended ? Cell(static_cast<double>(outcome.exit_code)) : Cell());
  row.push_back(ended ? Cell(outcome.seconds) : Cell());
  row.push_back(text_cell(outcome.host));
  row.push_back(text_cell(outcome.engine));
  row.emplace_back(static_cast<double>(result.trial.cores));
  row.push_back(result.holds ? Cell(*result.holds ? 1.0 : 0.0) : Cell());
  row.push_back(text_cell(result.state_hash));
  row.push_back(text_cell(result.processor));
  row.push_back(text_cell(result.commit));
  for (std::size_t i = 0; i < results.figures.size(); ++i) {
    const bool there = i < result.figures.size() && result.figures[i].has_value();
    row.push_back(there ? Cell(*result.figures[i]) : Cell());
  }
  return row;
}

std::string results_csv(const SweepSpec& spec, const Results& results) {
  std::string csv;
  const auto add_line = [&csv](const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) csv += (i == 0 ? "" : ",") + cells[i];
    csv += "\n";
  };
  std::vector<std::string> cells;
  for (const std::string& column : result_columns(spec, results)) cells.push_back(csv_cell(column));
  add_line(cells);
  for (const TrialResult& result : results.trials) {
    cells.clear();
    for (const Cell& cell : result_row(spec, results, result)) cells.push_back(csv_cell(cell));
    add_line(cells);
  }
  return csv;
}

}  // namespace poise::sweep
