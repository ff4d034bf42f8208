// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/tree_cache_options.h"
#include "poise/scene/scene.h"
#include "studies/timing_document.h"

namespace poise::app {

/// The command lines of `poise study cost`, `cache`, `scaling` and `free`.
struct StudyTimingOptions {
  std::string scene = "jacks";
  std::vector<std::uint64_t> bodies, thread_counts;
  std::optional<std::uint64_t> frames, skip, settle, rounds, threads;
  std::optional<double> deadline_ms;
  std::string executor;
  std::string json, markdown;
  TreeCacheOptions tree_cache;
  bool quiet = false;
};

/// Declare the options; `options` must outlive the parse.
void add_study_cost_options(CLI::App& command, StudyTimingOptions& options);
void add_study_cache_options(CLI::App& command, StudyTimingOptions& options);
void add_study_scaling_options(CLI::App& command, StudyTimingOptions& options);
void add_study_free_options(CLI::App& command, StudyTimingOptions& options);

/// Nanoseconds a candidate pair and a body of each mandatory stage, falling and settled. Returns the exit code, as the
/// next three.
int study_cost(const StudyTimingOptions& options);
/// Frames of a settled scene with what earlier ones found out, and without.
int study_cache(const StudyTimingOptions& options);
/// Refinement on several numbers of threads.
int study_scaling(const StudyTimingOptions& options);
/// Instructions of a step with each feature off and on; kExitRequirementFailed where one that is off executes something
/// of its own.
int study_free(const StudyTimingOptions& options);

/// What these share: options that contradict each other, a scene to run, who measured.
Status check_timing_options(const StudyTimingOptions& options);
Result<SceneRun> timed_scene(const StudyTimingOptions& options, std::uint64_t bodies, int threads);
/// Makes the next frame start anew, with the same state: every body is moved away and back, so nothing is known of its
/// pairs but their accumulated impulses.
Status forget_pairs(SceneRun& run);
io::MeasuredBy measured_by(const StudyTimingOptions& options, int threads);
ExecutorKind timed_executor(const StudyTimingOptions& options, int threads);
/// JSON and markdown where they are asked for, else the markdown on the standard output. The exit code.
int write_timing(const StudyTimingOptions& options, const char* study, const std::string& json,
                 const std::string& markdown);

}  // namespace poise::app
