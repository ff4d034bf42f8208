// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "sweep/results.h"

namespace poise::sweep {

/// A cell: nothing, a number or a text.
using Cell = std::variant<std::monostate, double, std::string>;

/// Names of the columns of the joined results.
std::vector<std::string> result_columns(const SweepSpec& spec, const Results& results);

/// The cells of one trial, one for each column.
std::vector<Cell> result_row(const SweepSpec& spec, const Results& results, const TrialResult& trial);

}  // namespace poise::sweep
