// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"

namespace poise::io {

/// Deepest nesting that is accepted.
inline constexpr std::size_t kMaxJsonDepth = 64;

/// A parsed JSON value. Members of an object keep the order of the file.
struct JsonValue {
  enum class Kind : std::uint8_t { Null, Boolean, Number, String, Array, Object };
  Kind kind = Kind::Null;
  bool boolean = false;
  double number = 0;         ///< finite
  bool is_unsigned = false;  ///< written as an integer that `magnitude` represents exactly
  std::uint64_t magnitude = 0;
  std::string text;               ///< of a string; for a number, the text of the file
  std::vector<std::string> keys;  ///< of an object, parallel to items
  std::vector<JsonValue> items;

  /// The member of an object, or nullptr.
  [[nodiscard]] const JsonValue* find(std::string_view key) const;
};

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
