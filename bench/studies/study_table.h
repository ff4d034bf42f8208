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

/// A value of a study; none is an empty cell, null in JSON.
using StudyCell = std::variant<std::monostate, bool, std::uint64_t, double, std::string>;

struct StudyColumn {
  std::string name;   ///< in JSON
  std::string title;  ///< in tables; empty: in JSON only
  int digits = 3;     ///< of numbers in tables, after the point
};

/// What a study of times found: one table, and what it was made with. Invariant to hold: a cell a column in each row.
struct StudyTable {
  std::string schema;   ///< `poise.NAME/1`
  std::string command;  ///< that makes it
  std::vector<StudyColumn> columns;
  std::vector<std::vector<StudyCell>> rows;
  std::vector<std::pair<std::string, StudyCell>> facts;  ///< settings, and figures of the whole
  Machine machine;
  BuildFacts build;
};

/// JSON of the table: facts, then `rows`, an object a row. Full precision; ends in a newline.
std::string study_json(const StudyTable& table);
/// For a terminal, columns set in line; and for docs.
std::string study_text(const StudyTable& table);
std::string study_markdown(const StudyTable& table);

/// A data block for gnuplot with two columns of the rows where both are numbers, in order, `only` those whose
/// first-named column has this text.
struct StudyFilter {
  std::string column, text;
};
std::string study_points(const StudyTable& table, const std::string& block, const std::string& x, const std::string& y,
                         const std::vector<StudyFilter>& only);

}  // namespace poise::io
