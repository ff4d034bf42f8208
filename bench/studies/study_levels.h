// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/options/tree_cache_options.h"
#include "app/report/line_chart.h"
#include "poise/result.h"
#include "studies/gnuplot.h"
#include "verify/pair_probe.h"
#include "world/contact_model_names.h"

namespace poise::app {

/// The command line of `poise study levels`.
struct StudyLevelsOptions {
  std::vector<std::string> meshes;
  std::string pairs, models, levels, half = "report";
  std::string json, csv, markdown;
  PlotFiles picture;
  std::optional<std::uint64_t> touches, seed, depth, fineness, threads;
  TreeCacheOptions tree_cache;
  bool quiet = false;
  std::vector<LineChart>* page_charts = nullptr;  ///< receives what the page of the study shows
};

/// Declares the options; `options` must outlive the parse.
void add_study_levels_options(CLI::App& command, StudyLevelsOptions& options);

/// The parsed options that are lists.
struct LevelsPlan {
  std::vector<std::pair<std::string, std::string>> pairs;  ///< names of shapes or files
  std::vector<simulation::NamedContactModel> models;
  std::vector<simulation::ProbeLevel> levels;
  std::vector<std::string> missing;  ///< meshes of the docs that are not installed
};
/// Refused with option, value and rule: an unknown shape, model or level, a level twice, outputs that are one file.
Result<LevelsPlan> plan_of(const StudyLevelsOptions& options);

/// Throws shapes at each other and compares the results of each level with the exact ones. Returns the exit code.
int study_levels(const StudyLevelsOptions& options);

}  // namespace poise::app
