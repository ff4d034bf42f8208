// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "parallel/interrupt.h"
#include "poise/result.h"

namespace poise::app {

/// Runs gnuplot on a script that writes a PNG to its standard output, and returns that output. Refused (OutputFailed)
/// if gnuplot is missing or fails; Ctrl-C stops it.
Result<std::string> drawn_by_gnuplot(const std::string& script, const parallel::Interrupt& interrupt);

}  // namespace poise::app
