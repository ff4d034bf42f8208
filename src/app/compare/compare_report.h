// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "app/report/figures_page.h"
#include "scene/compare/comparison_document.h"

namespace poise::app {

/// The page of a comparison: conclusion, curves of E_seen, E_rel, E and regret against the budget, tables. `command` is
/// the command line.
FiguresDocument comparison_figures(const io::ComparisonDocument& document, std::vector<std::string> command);

/// E_seen against the budget, one curve a policy with its interval, as SVG.
std::string comparison_svg(const io::ComparisonDocument& document);

}  // namespace poise::app
