// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace poise::tests {

/// Finds words that were replaced by the field's (CHANGELOG.md, "Renamed"): one line for each use, with path and line
/// number. Empty for exempt paths: the changelog, and this test.
std::vector<std::string> old_words(std::string_view path, std::string_view text);

}  // namespace poise::tests
