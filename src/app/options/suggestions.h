// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace poise::app {

/// For a command line that `app` refused because of words that it does not know: which command or option was probably
/// meant, as `poise run: did you mean --frames instead of --frmaes?` with a line end each; empty where nothing is near.
std::string argument_hints(const CLI::App& app);

/// Takes these texts alone; the refusal names them and the nearest one.
CLI::Validator one_of(std::vector<std::string_view> names);

}  // namespace poise::app
