// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "assets/json/json_value.h"
#include "poise/result.h"

namespace poise::io {

/// Deepest nesting that is accepted.
inline constexpr std::size_t kMaxJsonDepth = 64;

/// Parses JSON with // and /* */ comments. Refused: syntax errors, with line and column; a number that a double cannot
/// hold, a member given twice and too deep nesting, each with its path. `name` begins every message.
Result<JsonValue> parse_json(std::string_view text, const std::string& name);

/// `path` + `key` in the form of messages: `shapes.ball`, or `shapes["odd name"]`.
std::string member_path(const std::string& path, std::string_view key);
/// `path[index]`.
std::string item_path(const std::string& path, std::size_t index);

/// A value in the form of messages: short, on one line, printable ASCII.
std::string shown(const JsonValue& value);
/// Text in the form of messages: quoted, at most 40 characters, everything but printable ASCII replaced.
std::string in_quotes(std::string_view text);
/// Text without quotes, everything but printable ASCII replaced.
std::string printable(std::string_view text);

}  // namespace poise::io
