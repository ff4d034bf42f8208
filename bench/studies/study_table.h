// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "scene/made_by.h"

namespace poise::io {

/// A value of a study; monostate is an empty cell, and null in JSON.
using StudyCell = std::variant<std::monostate, bool, std::uint64_t, double, std::string>;

struct StudyColumn {
  std::string name;   ///< in JSON
  std::string title;  ///< in tables; empty: in JSON only
  int digits = 3;     ///< of numbers in tables, after the point
};

/// Result of a study of times: one table, and its settings. Invariant: each row has one cell for each column.
struct StudyTable {
  std::string schema;   ///< `poise.NAME/1`
  std::string command;  ///< command that produces it
  std::vector<StudyColumn> columns;
  std::vector<std::vector<StudyCell>> rows;
  std::vector<std::pair<std::string, StudyCell>> facts;  ///< settings and overall figures
  Machine machine;
  BuildFacts build;
};

/// JSON of the table: facts, then `rows`, an object a row. Full precision; ends in a newline.
std::string study_json(const StudyTable& table);
/// The table for a terminal, with aligned columns; and for docs.
std::string study_text(const StudyTable& table);
std::string study_markdown(const StudyTable& table);

/// A data block for gnuplot with two columns of the rows in which both are numbers, in order. `only` selects the rows
/// whose named column has this text.
struct StudyFilter {
  std::string column, text;
};
std::string study_points(const StudyTable& table, const std::string& block, const std::string& x, const std::string& y,
                         const std::vector<StudyFilter>& only);

}  // namespace poise::io
