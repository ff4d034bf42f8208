// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace poise::io {

/// A text as a field of a CSV row (RFC 4180): in quotes where it has commas, quotes or line breaks.
inline std::string csv_text(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace poise::io
