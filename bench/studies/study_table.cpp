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

using Columns = std::vector<StudyColumn>;
using Rows = std::vector<std::vector<StudyCell>>;

// Header and rows as they are printed: without columns that have no title, or nothing in any row.
std::vector<std::vector<std::string>> shown(const Columns& columns, const Rows& rows) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto empty = [&](const std::vector<StudyCell>& row) {
      return std::holds_alternative<std::monostate>(row[i]);
    };
    if (!columns[i].title.empty() && (rows.empty() || !std::ranges::all_of(rows, empty))) kept.push_back(i);
  }
  std::vector<std::vector<std::string>> lines(1);
  for (const std::size_t i : kept) lines[0].push_back(columns[i].title);
  for (const std::vector<StudyCell>& row : rows) {
    std::vector<std::string>& line = lines.emplace_back();
    for (const std::size_t i : kept) line.push_back(text_of(row[i], columns[i].digits));
  }
  return lines;
}

Json json_rows(const Columns& columns, const Rows& rows) {
  Json made = Json::array();
  for (const std::vector<StudyCell>& row : rows) {
    Json& object = made.emplace_back(Json::object());
    for (std::size_t i = 0; i < columns.size(); ++i) object[columns[i].name] = json_of(row[i]);
  }
  return made;
}

std::string text_rows(const Columns& columns, const Rows& rows) {
  const std::vector<std::vector<std::string>> lines = shown(columns, rows);
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
  return text;
}

std::string markdown_rows(const Columns& columns, const Rows& rows) {
  std::string text;
  bool head = true;
  for (const auto& line : shown(columns, rows)) {
    text += fmt::format("| {} |\n", fmt::join(line, " | "));
    if (!head) continue;
    text += "|";
    for (std::size_t i = 0; i < line.size(); ++i) text += "---|";
    text += "\n";
    head = false;
  }
  return text + "\n";
}

// A table without titles is for JSON alone.
bool is_shown(const StudySummary& part) {
  return std::ranges::any_of(part.columns, [](const StudyColumn& column) { return !column.title.empty(); });
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
  json["rows"] = json_rows(table.columns, table.rows);
  if (table.summary) json[table.summary->name] = json_rows(table.summary->columns, table.summary->rows);
  for (const StudySummary& part : table.more) json[part.name] = json_rows(part.columns, part.rows);
  json["machine"] = table.machine;
  json["build"] = table.build;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string study_text(const StudyTable& table) {
  std::string text = text_rows(table.columns, table.rows);
  if (table.summary) text += "\n" + text_rows(table.summary->columns, table.summary->rows);
  for (const StudySummary& part : table.more) {
    if (is_shown(part)) text += "\n" + text_rows(part.columns, part.rows);
  }
  for (const auto& [name, value] : table.facts) text += fmt::format("{}: {}\n", name, text_of(value, 3));
  return text;
}

std::string study_markdown(const StudyTable& table) {
  std::string text = markdown_rows(table.columns, table.rows);
  if (table.summary) text += markdown_rows(table.summary->columns, table.summary->rows);
  for (const StudySummary& part : table.more) {
    if (is_shown(part)) text += markdown_rows(part.columns, part.rows);
  }
  for (const auto& [name, value] : table.facts) text += fmt::format("{}: {}; ", name, text_of(value, 3));
  return text + made_by(table);
}

Result<std::vector<StudyCell>> first_row_of(const std::string& json, const std::vector<StudyColumn>& columns) {
  const Json document = Json::parse(json, nullptr, false);
  const Error refused = bad_input("a study in a child process wrote no row");
  if (!document.is_object() || !document.contains("rows") || !document["rows"].is_array() || document["rows"].empty())
    return refused;
  const Json& row = document["rows"].front();
  std::vector<StudyCell> cells;
  for (const StudyColumn& column : columns) {
    if (!row.is_object() || !row.contains(column.name)) return refused;
    const Json& value = row[column.name];
    if (value.is_null()) {
      cells.emplace_back();
    } else if (value.is_boolean()) {
      cells.emplace_back(value.get<bool>());
    } else if (value.is_number_unsigned()) {
      cells.emplace_back(value.get<std::uint64_t>());
    } else if (value.is_number()) {
      cells.emplace_back(value.get<double>());
    } else if (value.is_string()) {
      cells.emplace_back(value.get<std::string>());
    } else {
      return refused;
    }
  }
  return cells;
}

std::vector<app::LinePoint> study_points(const StudyTable& table, const std::string& x, const std::string& y,
                                         const std::vector<StudyFilter>& only) {
  const auto place = [&](const std::string& name) {
    const auto at = std::ranges::find(table.columns, name, &StudyColumn::name);
    return static_cast<std::size_t>(at - table.columns.begin());
  };
  std::vector<app::LinePoint> points;
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
    if (px && py) points.push_back({*px, *py, {}, {}});
  }
  return points;
}

}  // namespace poise::io
