// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "assets/json/json_value.h"
#include "poise/result.h"

namespace poise::geometry {

/// Bytes of YAML within one collection in brackets or one text, which the parser holds whole. Chosen.
inline constexpr std::size_t kMostYamlStretch = std::size_t{1} << 18U;

/// The first document of a text in YAML as a value: scalars are strings, null and what an alias stands for are null.
/// Refused with the line: what is not YAML, nesting deeper than the parser's limit, and a stretch of more than
/// kMostYamlStretch. Memory in proportion to the text, and about 50 MB beside it for the longest stretch.
Result<io::JsonValue> parse_yaml(std::string_view text);

}  // namespace poise::geometry
