// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "poise/result.h"

namespace poise::app {

/// What is in the page of live runs, and in no other.
inline constexpr std::string_view kLiveMark = "<!-- poise:live -->";

/// Where the built page may lie, in the order of report_template_places().
std::vector<std::filesystem::path> live_page_places();

/// The page: the first of these files that is there. Refused: none is there, which is told with how to build it; a file
/// that is no page for live runs.
Result<std::string> read_live_page(const std::vector<std::filesystem::path>& places = live_page_places());

}  // namespace poise::app
