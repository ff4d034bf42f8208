// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/capture/run_capture.h"
#include "app/options/time_options.h"
#include "app/options/tree_cache_options.h"
#include "app/picture/picture_options.h"
#include "poise/result.h"
#include "poise/scene/scene.h"
#include "poise/world.h"

namespace poise::app {

/// The command line of `poise run`, each value in its range, not yet checked against each other.
struct RunOptions {
  std::string scene;
  std::optional<std::uint64_t> frames, bodies, warmup, threads, budget_work, max_level, seed, reference_every,
      states_every;
  bool polygons = false;             ///< --max-level polygons
  std::optional<bool> backtracking;  ///< not given: as the scene says
  std::optional<double> deadline_ms, host_work_ms, spin_us;
  std::optional<bool> sleeping;  ///< not given: as the scene says
  std::string islands_wait;      ///< empty: as the scene says
  bool paced = false;
  bool quiet = false;
  std::string policy, contact = "fitted", clock = "wall", executor;
  std::string json, states, frames_csv, trace, record;
  std::string report;  ///< a folder
  std::string gaze;
  std::string affinity;
  std::optional<std::uint64_t> realtime;
  std::optional<std::string> require;
  std::vector<std::string> weights;  ///< CUE=VALUE each
  PictureOptions picture;
  CaptureOptions capture;
  TreeCacheOptions tree_cache;
  std::optional<std::uint64_t> max_memory_mib;
  TimeOptions time;
};

/// Declares the options on a subcommand.
void add_run_options(CLI::App& command, RunOptions& options);

/// Of these `--policy` and `--weight` alone.
void add_policy_options(CLI::App& command, RunOptions& options);

/// Refused: options that contradict each other, as one line.
Status check_run_options(const RunOptions& options);
/// Refuses an output into a file that the scene names.
Status check_run_files(const RunOptions& options, const Scene& scene);

/// Puts what the command line switches on or off, the policy file and the weights into the scene. `errors` gets every
/// refusal of the file, one line each.
Status apply_to_scene(const RunOptions& options, Scene& scene, std::vector<std::string>& errors);
/// What the World is made with; gravity and seed come from the scene.
WorldSettings world_settings(const RunOptions& options, const Scene& scene);
ExecutorKind executor_kind(const RunOptions& options);
/// `0,2-3` as 0, 2, 3; empty for no text. Refused: anything else, and more than 256.
Result<std::vector<int>> processor_list(const std::string& text);
/// Tells on stderr where there are more threads than processors that this process may use.
void warn_of_threads(std::string_view command, int threads);
/// `tbb`, `threads` or `serial`.
const char* executor_name(ExecutorKind kind);

}  // namespace poise::app
