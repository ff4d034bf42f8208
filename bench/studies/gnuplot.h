// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>

#include "parallel/interrupt.h"
#include "poise/result.h"

namespace poise::app {

/// The files of a study's picture; empty for none.
struct PlotFiles {
  std::string png, png_dark;  ///< on a light and on a dark ground
  std::string svg;            ///< on either, as a browser prefers
  [[nodiscard]] bool any() const { return !png.empty() || !png_dark.empty() || !svg.empty(); }
};
/// `--picture` and `--picture-dark`; `what` tells what is drawn.
void add_plot_files(CLI::App& command, PlotFiles& files, const std::string& what);
/// Refused: the standard output, and pictures that are not PNG.
Status check_plot_files(const PlotFiles& files);

/// Runs gnuplot on a script that writes a PNG on a light ground to its standard output, once for each file. Refused
/// (OutputFailed) if gnuplot is missing or fails; Ctrl-C stops it.
Status draw_by_gnuplot(const std::string& script, const PlotFiles& files, const parallel::Interrupt& interrupt);

/// The same script, writing SVG.
std::string svg_script(std::string script);
/// An SVG that gnuplot wrote, so that it is dark where a browser prefers that.
std::string svg_of_gnuplot(const std::string& svg);
/// The beginning of every script: a PNG of this size in the colours of charts (chart_theme.h), the key below. There is
/// no frame, only a thin grid, so that a curve at 0 or
/// at an end of the axis is seen.
std::string plot_style(std::size_t width_px, std::size_t height_px);
/// Colour of `linetype` line + 1 of that style, as #rrggbb.
std::string plot_color(std::size_t line);

}  // namespace poise::app
