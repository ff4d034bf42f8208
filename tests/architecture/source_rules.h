// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace poise::tests {

/// Every rule of docs/architecture.md that one file breaks, a line each: `path:line: what, and the rule`. `path` is
/// relative to the repository, with forward slashes; it decides which rules apply. `text` is the whole file.
std::vector<std::string> broken_rules(std::string_view path, std::string_view text);

/// The same text with comments and the content of string and character literals replaced by blanks; lines stay in
/// place.
std::string code_only(std::string_view text);

/// A part of the code; `rank` is its position in the order: a file may include files of a lower rank, or of its own
/// room.
struct RoomInOrder {
  std::string_view name;
  int rank = 0;
};

/// The room of a file (as above) or of a folder with its last slash; empty outside of all rooms.
std::optional<RoomInOrder> room_in_order(std::string_view path);

/// A function whose body is longer than 80 lines, from the line of its opening brace to that of the closing one.
struct LongFunction {
  std::size_t line = 0;  ///< of the opening brace
  std::size_t lines = 0;
};
/// The long functions of `code`, which must be free of comments and literals (code_only). A block behind a `)` counts
/// as a function, so a loop that is too long is listed in addition to its function.
std::vector<LongFunction> long_functions(std::string_view code);

}  // namespace poise::tests
