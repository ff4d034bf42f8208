// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/report/line_chart.h"

namespace poise::app {

/// The command line of `poise study trees`.
struct StudyTreesOptions {
  std::vector<std::string> meshes, presets;
  std::string json, markdown, csv;
  std::optional<std::uint64_t> depth, threads, seed, samples, most;
  bool scaling = false;
  bool quiet = false;
  std::vector<LineChart>* page_charts = nullptr;  ///< receives what the page of the study shows
};

/// Declares the options; `options` must outlive the parse.
void add_study_trees_options(CLI::App& command, StudyTreesOptions& options);

/// Builds each tree in a process of its own, so that its CPU time and memory are measured separately. Returns the exit
/// code.
int study_trees(const StudyTreesOptions& options);

}  // namespace poise::app
