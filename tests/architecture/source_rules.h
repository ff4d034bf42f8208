// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace poise::tests {

/// Every rule of ARCHITECTURE that one file breaks, a line each: `path:line: what, and the rule`. `path` is relative to
/// the repository, with forward slashes; it decides which rules apply. `text` is the whole file.
std::vector<std::string> broken_rules(std::string_view path, std::string_view text);

/// The same text with comments and the insides of string and character literals blanked out, line by line in place.
std::string code_only(std::string_view text);

}  // namespace poise::tests
