// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "app/report/line_chart.h"
#include "app/tree/tree_document.h"

namespace poise::io {

/// One mesh and the tree built for it, or the refusal.
struct TreesRow {
  std::string mesh;     ///< short name, for tables
  std::string file;     ///< empty for a mesh that was generated for the study
  std::string refusal;  ///< empty if there is a tree
  std::size_t triangles = 0;
  double diagonal_m = 0;
  Solidity solidity = Solidity::Solid;
  MeasuredTree tree;
};

/// The results of `poise study trees`.
struct TreesDocument {
  std::string study;  ///< meshes or scaling
  std::size_t samples = 0;
  std::uint64_t seed = 0;
  int threads = 0;
  std::vector<TreesRow> rows;
  Machine machine;
  BuildFacts build;
};

/// Makes a row from the output of `poise tree --json`. Refused: text that is not such a document.
Result<TreesRow> row_of_tree_json(const std::string& text);

/// `poise.trees/1`, ending in a newline.
std::string trees_json(const TreesDocument& document);
/// A table of fixed-width columns for a terminal: lengths in % of the diagonal, largest / mean / volume ratio for each
/// level.
std::string trees_table(const TreesDocument& document);
/// The same as a Markdown table with the machine below it.
std::string trees_markdown(const TreesDocument& document);
/// What the page of the study draws: fit against level, and cost against the number of triangles.
std::vector<app::LineChart> trees_charts(const TreesDocument& document);
/// One line a mesh and level, with a header.
std::string trees_csv(const TreesDocument& document);

}  // namespace poise::io
