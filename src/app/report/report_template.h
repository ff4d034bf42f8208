// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "poise/result.h"

namespace poise::app {

/// Where the built page of the viewer may lie, in the order in which it is looked for: beside an installed program, in
/// the source, where it was to be installed.
std::vector<std::filesystem::path> report_template_places();

/// The page without data: the first of these files that is there. Refused: none is there, which is told with how to
/// build it; a file without a place for the data.
Result<std::string> read_report_template(const std::vector<std::filesystem::path>& places = report_template_places());

}  // namespace poise::app
