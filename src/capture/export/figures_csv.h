// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "capture/capture.h"

namespace poise::capture {

/// A row a frame of what a capture says of it beside its bodies, times in ms; docs/capture.md has the columns. Cells of
/// what was not measured are empty.
std::string figures_header();
std::string figures_row(const PackedFrame& frame);

}  // namespace poise::capture
