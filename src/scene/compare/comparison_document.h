// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "scene/compare/comparison.h"
#include "scene/made_by.h"

namespace poise::io {

/// A comparison and what it was made with.
struct ComparisonDocument {
  std::string scene;
  std::string budget_unit;  ///< `work_units`, `percent` (of the work of full refinement of each frame) or `ms`
  std::string clock;
  std::uint64_t seed = 0;
  std::size_t bodies = 0;
  std::uint64_t history = 1;  ///< frames that each policy stepped by itself
  Machine machine;
  BuildFacts build;
  PolicyComparison result;
};

/// `poise.compare/1`, with a newline at its end.
std::string comparison_json(const ComparisonDocument& document);
/// One row a policy and budget; the columns are the members of rows[] in the JSON.
std::string comparison_csv(const ComparisonDocument& document);
/// The table for the standard output, with the conclusion as its last line.
std::string comparison_table(const ComparisonDocument& document);

}  // namespace poise::io
