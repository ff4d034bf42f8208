// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "assets/json/json_value.h"
#include "poise/result.h"

namespace poise::geometry {

/// Bytes of YAML within one collection in brackets or one text, which the parser holds whole, or in comments, which it
/// does not tell of. Chosen.
inline constexpr std::size_t kMostYamlStretch = std::size_t{1} << 18U;

struct YamlDocument {
  io::JsonValue root;  ///< scalars are strings; null, and what an alias stands for, are null
  int alias_line = 0;  ///< of the first alias (`*name`), counted from 1; 0 if there is none
};

/// The first document of a text in YAML. Refused: what is not YAML and nesting deeper than the parser's limit, with the
/// line, and a stretch of more than kMostYamlStretch. Memory in proportion to the text, and about 50 MB beside it for
/// the longest stretch.
Result<YamlDocument> parse_yaml(std::string_view text);

}  // namespace poise::geometry
