// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "app/report/line_chart.h"
#include "poise/result.h"
#include "scene/made_by.h"

namespace poise::io {

/// A value of a study; monostate is an empty cell, and null in JSON.
using StudyCell = std::variant<std::monostate, bool, std::uint64_t, double, std::string>;

struct StudyColumn {
  std::string name;   ///< in JSON
  std::string title;  ///< in tables; empty: in JSON only
  int digits = 3;     ///< of numbers in tables, after the point
};

/// Rows of their own that say what the rows of a study have in common. As those of StudyTable.
struct StudySummary {
  std::string name;  ///< in JSON
  std::vector<StudyColumn> columns;
  std::vector<std::vector<StudyCell>> rows;
};

/// Result of a study of times: one table, and its settings. Invariant: each row has one cell for each column.
struct StudyTable {
  std::string schema;   ///< `poise.NAME/1`
  std::string command;  ///< command that produces it
  std::vector<StudyColumn> columns;
  std::vector<std::vector<StudyCell>> rows;
  std::optional<StudySummary> summary;
  std::vector<StudySummary> more;                        ///< further tables, after the summary
  std::vector<std::pair<std::string, StudyCell>> facts;  ///< settings and overall figures
  Machine machine;
  BuildFacts build;
};

/// JSON of the table: facts, then `rows`, an object a row, then the summary and further tables under their names. Full
/// precision; ends in a newline.
std::string study_json(const StudyTable& table);
/// The first of the `rows` of such a JSON by columns: what a study in a child process found. Refused: anything else,
/// and a cell that is neither a number, a text, a truth value nor null.
Result<std::vector<StudyCell>> first_row_of(const std::string& json, const std::vector<StudyColumn>& columns);
/// The table for a terminal, with aligned columns; and for docs. Both without columns that are empty in every row.
std::string study_text(const StudyTable& table);
std::string study_markdown(const StudyTable& table);

/// Selects the rows whose named column has this text.
struct StudyFilter {
  std::string column, text;
};
/// Two columns of the rows in which both are numbers, in order, as points of a line.
std::vector<app::LinePoint> study_points(const StudyTable& table, const std::string& x, const std::string& y,
                                         const std::vector<StudyFilter>& only);

}  // namespace poise::io
