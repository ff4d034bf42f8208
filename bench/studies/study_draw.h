// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <string>
#include <vector>

#include "app/report/line_chart.h"
#include "poise/result.h"
#include "studies/gnuplot.h"

namespace poise::app {

/// The JSON of a study with the member `drawing`: its charts, and how many of them its picture has in a row. So the
/// picture can be drawn again without a measurement.
std::string with_charts(const std::string& json, const std::vector<LineChart>& charts, std::size_t columns);

/// The drawing of such a JSON.
struct StudyDrawing {
  std::vector<LineChart> charts;
  std::size_t columns = 1;
};
/// Refused: what is no JSON of a study, or has no charts; `name` names it.
Result<StudyDrawing> drawing_of(const std::string& json, const std::string& name);

/// The command line of `poise study draw`.
struct StudyDrawOptions {
  std::string study;  ///< the file that --json of a study wrote
  PlotFiles picture;
};
void add_study_draw_options(CLI::App& command, StudyDrawOptions& options);
/// Returns the exit code.
int study_draw(const StudyDrawOptions& options);

}  // namespace poise::app
