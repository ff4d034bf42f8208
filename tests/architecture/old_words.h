// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace poise::tests {

/// The words that were replaced by the field's (CHANGELOG.md, "Renamed"): each use of one in a text, one line each with
/// path and line number. Empty for paths that are exempt: the changelog, and rooms whose rewriting is under way.
std::vector<std::string> old_words(std::string_view path, std::string_view text);

}  // namespace poise::tests
