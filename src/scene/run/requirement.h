// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"
#include "scene/run/run_document.h"

namespace poise::io {

struct Operand {
  std::string name;  ///< empty: the operand is a number
  double number = 0;
};

enum class Relation : std::uint8_t { Less, AtMost, Greater, AtLeast, Equal, Unequal };

struct Comparison {
  Operand left, right;
  Relation relation = Relation::Less;
  std::string text;  ///< as it was written
};

/// Comparisons that must all hold for a run.
using Requirement = std::vector<Comparison>;

/// Parses `NAME OP NUMBER && ...`; either side may be a name or a number. Refused with the part that is invalid.
Result<Requirement> parse_requirement(std::string_view text);

/// Refused: a name that is not in `figures`; the message suggests the nearest one.
Status check_names(const Requirement& requirement, std::span<const NamedFigure> figures);

/// One sentence for each comparison that does not hold, with the values. A comparison with an undefined figure does not
/// hold.
std::vector<std::string> failed_comparisons(const Requirement& requirement, std::span<const NamedFigure> figures);

}  // namespace poise::io
