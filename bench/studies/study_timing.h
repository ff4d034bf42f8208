// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/options/tree_cache_options.h"
#include "poise/scene/scene.h"
#include "studies/timing_document.h"

namespace poise::app {

/// The command lines of `poise study cost`, `cache`, `scaling` and `free`.
struct StudyTimingOptions {
  std::string scene = "jacks";
  std::vector<std::uint64_t> bodies, thread_counts;
  std::optional<std::uint64_t> frames, skip, settle, rounds, threads;
  std::optional<double> deadline_ms;
  bool span = false;
  std::string executor;
  std::string json, markdown;
  std::vector<LineChart>* page_charts = nullptr;  ///< receives what the page of the study shows
  TreeCacheOptions tree_cache;
  bool quiet = false;
};

/// Declare the options; `options` must outlive the parse.
void add_study_cost_options(CLI::App& command, StudyTimingOptions& options);
void add_study_cache_options(CLI::App& command, StudyTimingOptions& options);
void add_study_scaling_options(CLI::App& command, StudyTimingOptions& options);
void add_study_free_options(CLI::App& command, StudyTimingOptions& options);

/// Measures nanoseconds a candidate pair and a body for each mandatory stage, while falling and settled. This function
/// and the next three return the exit code.
int study_cost(const StudyTimingOptions& options);
/// Compares frames of a settled scene with and without cached data of earlier frames.
int study_cache(const StudyTimingOptions& options);
/// Measures refinement on several numbers of threads; with `span`, counts the critical path of frames instead.
int study_scaling(const StudyTimingOptions& options);
/// Counts the instructions of a step with each feature off and on; kExitRequirementFailed if a feature that is off
/// executes code of its own.
int study_free(const StudyTimingOptions& options);

/// What study_scaling does with `span`.
int study_span(const StudyTimingOptions& options);

/// Shared by these studies: checking contradictory options, the scene to run, and the machine and build.
Status check_timing_options(const StudyTimingOptions& options);
Result<SceneRun> timed_scene(const StudyTimingOptions& options, std::uint64_t bodies, int threads);
/// Makes the next frame start without cached data, from the same state: every body is moved away and back, which clears
/// the cache of its pairs except their accumulated impulses.
Status forget_pairs(SceneRun& run);
io::MeasuredBy measured_by(const StudyTimingOptions& options, int threads);
ExecutorKind timed_executor(const StudyTimingOptions& options, int threads);
/// Writes JSON and markdown if requested, else the markdown to the standard output; gives the charts to the page.
/// Returns the exit code.
int write_timing(const StudyTimingOptions& options, const char* study, const std::string& json,
                 const std::string& markdown, std::vector<LineChart> charts);

}  // namespace poise::app
