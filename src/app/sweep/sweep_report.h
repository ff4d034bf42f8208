// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "app/report/figures_page.h"
#include "sweep/frontier.h"

namespace poise::app {

/// A text as a part of a file's name: letters, digits and single dashes.
std::string picture_name(const std::string& text);

/// The page of a sweep: the frontier, heat maps over its two axes, curves of the figures along every axis of numbers,
/// and tables. `command` are the words of the command line.
FiguresDocument sweep_figures(const sweep::SweepSpec& spec, const sweep::Results& results,
                              const std::vector<sweep::Group>& groups, std::vector<std::string> command);

}  // namespace poise::app
