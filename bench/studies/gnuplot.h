// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>

#include "parallel/interrupt.h"
#include "poise/result.h"

namespace poise::app {

/// Runs gnuplot on a script that writes a PNG to its standard output, and writes that picture into the file `png`, and
/// drawn anew as SVG into `svg`; nothing for an empty path. Refused (OutputFailed) if gnuplot is missing or fails;
/// Ctrl-C stops it.
Status draw_by_gnuplot(const std::string& script, const std::string& png, const std::string& svg,
                       const parallel::Interrupt& interrupt);

/// The same script, writing SVG.
std::string svg_script(std::string script);
/// The beginning of every script: a PNG of this size on its own light ground, colours that people with impaired colour
/// vision tell apart (Okabe and Ito 2008), the key below. There is no frame, only a thin grid, so that a curve at 0 or
/// at an end of the axis is seen.
std::string plot_style(std::size_t width_px, std::size_t height_px);
/// Colour of `linetype` line + 1 of that style, as #rrggbb.
std::string plot_color(std::size_t line);

}  // namespace poise::app
