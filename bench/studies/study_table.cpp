// SPDX-License-Identifier: MIT
#include "studies/study_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace poise::io {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const StudyCell& cell) {
  return std::visit(
      [](const auto& value) -> Json {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::monostate>) {
          return nullptr;
        } else {
          return value;
        }
      },
      cell);
}

std::string text_of(const StudyCell& cell, int digits) {
  struct Shown {
    int digits;
    std::string operator()(std::monostate) const { return "-"; }
    std::string operator()(bool value) const { return value ? "yes" : "no"; }
    std::string operator()(std::uint64_t value) const { return std::to_string(value); }
    std::string operator()(double value) const { return fmt::format("{:.{}f}", value, digits); }
    std::string operator()(const std::string& value) const { return value; }
  };
  return std::visit(Shown{digits}, cell);
}

std::optional<double> number_of(const StudyCell& cell) {
  if (const auto* value = std::get_if<double>(&cell)) return *value;
  if (const auto* value = std::get_if<std::uint64_t>(&cell)) return static_cast<double>(*value);
  return std::nullopt;
}

// Header and rows as they are printed.
std::vector<std::vector<std::string>> shown(const StudyTable& table) {
  std::vector<std::vector<std::string>> lines(1);
  for (const StudyColumn& column : table.columns) {
    if (!column.title.empty()) lines[0].push_back(column.title);
  }
  for (const std::vector<StudyCell>& row : table.rows) {
    std::vector<std::string>& line = lines.emplace_back();
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      if (!table.columns[i].title.empty()) line.push_back(text_of(row[i], table.columns[i].digits));
    }
  }
  return lines;
}

std::string made_by(const StudyTable& table) {
  return fmt::format("`{}`; {}, {} cores, {}; poise {}, {}, {}\n", table.command, table.machine.processor,
                     table.machine.cores, table.machine.system, table.build.version, table.build.commit,
                     table.build.compiler);
}

}  // namespace

std::string study_json(const StudyTable& table) {
  Json json;
  json["schema"] = table.schema;
  json["command"] = table.command;
  for (const auto& [name, value] : table.facts) json[name] = json_of(value);
  json["rows"] = Json::array();
  for (const std::vector<StudyCell>& row : table.rows) {
    Json made = Json::object();
    for (std::size_t i = 0; i < table.columns.size(); ++i) made[table.columns[i].name] = json_of(row[i]);
    json["rows"].push_back(std::move(made));
  }
  json["machine"] = table.machine;
  json["build"] = table.build;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string study_text(const StudyTable& table) {
  const std::vector<std::vector<std::string>> lines = shown(table);
  std::vector<std::size_t> widths(lines[0].size());
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  }
  std::string text;
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      text += i == 0 ? fmt::format("{:<{}}", line[i], widths[i]) : fmt::format("  {:>{}}", line[i], widths[i]);
    }
    text += "\n";
  }
  for (const auto& [name, value] : table.facts) text += fmt::format("{}: {}\n", name, text_of(value, 3));
  return text;
}

std::string study_markdown(const StudyTable& table) {
  std::string text;
  bool head = true;
  for (const auto& line : shown(table)) {
    text += fmt::format("| {} |\n", fmt::join(line, " | "));
    if (!head) continue;
    text += "|";
    for (std::size_t i = 0; i < line.size(); ++i) text += "---|";
    text += "\n";
    head = false;
  }
  text += "\n";
  for (const auto& [name, value] : table.facts) text += fmt::format("{}: {}; ", name, text_of(value, 3));
  return text + made_by(table);
}

std::string study_points(const StudyTable& table, const std::string& block, const std::string& x, const std::string& y,
                         const std::vector<StudyFilter>& only) {
  const auto place = [&](const std::string& name) {
    const auto at = std::ranges::find(table.columns, name, &StudyColumn::name);
    return static_cast<std::size_t>(at - table.columns.begin());
  };
  std::string text = fmt::format("${} << EOD\n", block);
  const std::size_t at_x = place(x);
  const std::size_t at_y = place(y);
  for (const std::vector<StudyCell>& row : table.rows) {
    const bool wanted = std::ranges::all_of(only, [&](const StudyFilter& filter) {
      const std::size_t at = place(filter.column);
      return at < row.size() && text_of(row[at], 6) == filter.text;
    });
    if (!wanted || at_x >= row.size() || at_y >= row.size()) continue;
    const std::optional<double> px = number_of(row[at_x]);
    const std::optional<double> py = number_of(row[at_y]);
    if (px && py) text += fmt::format("{:g} {:g}\n", *px, *py);
  }
  return text + "EOD\n";
}

}  // namespace poise::io
