// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>

namespace poise::app {

/// Declares `poise import`, which makes a scene file of a model of MuJoCo or of glTF nodes. `exit_code` must outlive
/// the parse.
void add_import_command(CLI::App& app, int& exit_code);

}  // namespace poise::app
