// SPDX-License-Identifier: MIT
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace poise::geometry {

/// What ends a line: a carriage return where the text has no line feed at all, as old programs wrote it.
inline char line_end_of(std::string_view text) {
  const bool old = text.find('\n') == std::string_view::npos && text.find('\r') != std::string_view::npos;
  return old ? '\r' : '\n';
}

/// A text without the mark of UTF-8 that may stand before it.
inline std::string_view without_byte_order_mark(std::string_view text) {
  return text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text;
}

/// Reads a text line by line and each line word by word, and never beyond its end. Blanks are spaces, tabs and carriage
/// returns; what follows `#` in a line is a comment if `comments` is set. Invariant: `line_` is the unread rest of line
/// number(), `rest_` begins behind its end.
class TextCursor {
 public:
  TextCursor(std::string_view text, bool comments) : TextCursor(text, comments, line_end_of(text)) {}
  TextCursor(std::string_view text, bool comments, char line_end)
      : rest_(text), line_end_(line_end), comments_(comments) {}

  /// Goes to the next line; false at the end of the text, and the line is then empty.
  bool next_line() {
    line_ = {};
    if (rest_.empty()) return false;
    ++number_;
    const std::size_t end = rest_.find(line_end_);
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    if (comments_) line_ = line_.substr(0, line_.find('#'));
    return true;
  }
  /// Goes on to the next line that has a word; false at the end of the text.
  bool next_line_with_words() {
    while (next_line()) {
      if (skip_blanks()) return true;
    }
    return false;
  }
  /// The next word of the line; empty at its end.
  std::string_view next_word() {
    if (!skip_blanks()) return {};
    const char* const begin = line_.data();
    const char* const last = begin + line_.size();
    const char* end = begin + 1;
    while (end != last && !is_blank(*end)) ++end;
    line_ = {end, static_cast<std::size_t>(last - end)};
    return {begin, static_cast<std::size_t>(end - begin)};
  }
  /// The next word of the text, in this line or one further on; empty at its end.
  std::string_view next_word_of_text() {
    for (;;) {
      const std::string_view word = next_word();
      if (!word.empty() || !next_line()) return word;
    }
  }
  /// Leaves out the rest of the line.
  void skip_line() { line_ = {}; }
  /// Of the line, counted from 1; 0 before the first.
  [[nodiscard]] std::size_t number() const { return number_; }
  [[nodiscard]] std::size_t bytes_left_of_line() const { return line_.size(); }
  /// Of this line and all that follow.
  [[nodiscard]] std::size_t bytes_left() const { return line_.size() + rest_.size(); }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
  bool skip_blanks() {
    const char* at = line_.data();
    const char* const end = at + line_.size();
    while (at != end && is_blank(*at)) ++at;
    line_ = {at, static_cast<std::size_t>(end - at)};
    return at != end;
  }

  std::string_view rest_, line_;
  std::size_t number_ = 0;
  char line_end_;
  bool comments_;
};

/// A word as a number, all of it; a plus before it is allowed.
template <class Number>
bool parse_number(std::string_view word, Number& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && end == word.data() + word.size();
}

inline bool parse_finite(std::string_view word, double& value) {
  return parse_number(word, value) && std::isfinite(value);
}

/// A word of a file for a message: short, printable ASCII.
std::string shown_word(std::string_view word);

}  // namespace poise::geometry
