// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/options/tree_cache_options.h"
#include "app/report/line_chart.h"
#include "studies/gnuplot.h"

namespace poise::app {

/// The command line of `poise study accuracy`.
struct StudyAccuracyOptions {
  std::vector<std::string> only;
  std::string json, markdown;
  PlotFiles picture;
  std::optional<std::uint64_t> threads, heaps;
  TreeCacheOptions tree_cache;
  bool list = false;
  std::vector<LineChart>* page_charts = nullptr;  ///< receives what the page of the study shows
  bool quiet = false;
};

/// Declares the options; `options` must outlive the parse.
void add_study_accuracy_options(CLI::App& command, StudyAccuracyOptions& options);

/// Runs the cases with a known result and compares. Returns the exit code: kExitRequirementFailed if a row is not
/// within its bound.
int study_accuracy(const StudyAccuracyOptions& options);

}  // namespace poise::app
