// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "app/report/line_chart.h"

namespace poise::app {

/// The options of a study that name what it writes; those that it does not have are null.
struct StudyFiles {
  std::string* json = nullptr;
  std::string* markdown = nullptr;
  /// Those of a picture that the page shows beside its charts; null where there is none.
  std::string* picture = nullptr;
  std::string* svg = nullptr;
  bool picture_needs_gnuplot = false;
  const bool* quiet = nullptr;  ///< set: where the page is, is not told
};

/// `--report FOLDER` of a study.
struct StudyReport {
  std::string study;                   ///< its name
  std::string description;             ///< in a few words
  std::string folder;                  ///< empty: no page
  std::vector<LineChart> charts = {};  ///< which the study gives
};
void add_study_report(CLI::App& command, StudyReport& report);

/// Runs a study and returns its exit code. With a folder, first lets it write there what the options do not name, as
/// `study.json` and `study.md`, for a picture `study.svg` and `study.png`, and makes the page of these files and of the
/// charts afterwards. A picture that needs gnuplot is left out without it, with a warning. Refused before the study: a
/// page that is not built, a folder that cannot be written, figures that go to the standard output.
int with_study_report(StudyReport& report, const StudyFiles& files, const std::function<int()>& study);

}  // namespace poise::app
