// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/options/tree_cache_options.h"
#include "app/process/progress.h"
#include "app/run/run_loop.h"
#include "parallel/interrupt.h"
#include "poise/scene/scene.h"
#include "studies/gnuplot.h"
#include "studies/study_charts.h"
#include "studies/study_table.h"

namespace poise::app {

/// Command-line options shared by the studies of times (compliance, forecast, constant-time, overload, population).
struct StudyTimesOptions {
  std::string scene;
  std::optional<std::uint64_t> frames, warmup, threads;
  std::optional<double> deadline_ms;
  std::string json, markdown;
  PlotFiles picture;
  bool quiet = false;
  TreeCacheOptions tree_cache;
  std::vector<LineChart>* page_charts = nullptr;  ///< receives what the page of the study shows
};
/// Those of the scene, of threads and of what is written.
void add_study_outputs(CLI::App& command, StudyTimesOptions& options, const std::string& default_scene,
                       std::uint64_t default_threads = 0);
/// Threads and tables, for studies that draw nothing.
void add_study_tables(CLI::App& command, StudyTimesOptions& options, std::uint64_t default_threads = 0);
/// Those of the outputs without the scene; `picture` tells what is drawn.
void add_study_files(CLI::App& command, StudyTimesOptions& options, const std::string& picture,
                     std::uint64_t default_threads = 0);
/// `--clock wall|work`; empty is wall.
void add_study_clock(CLI::App& command, std::string& clock);
void add_study_deadline(CLI::App& command, StudyTimesOptions& options);
/// Those of the outputs, `--frames`, `--warmup` and `--deadline`.
void add_study_times_options(CLI::App& command, StudyTimesOptions& options, const std::string& default_scene,
                             std::uint64_t default_frames, std::uint64_t default_warm_up);
/// Refused: two outputs into one file, a picture that is not a PNG, contradictory cache options.
Status check_study_times(const StudyTimesOptions& options);

/// One run of a study.
struct StudyRun {
  std::uint64_t bodies = 0;  ///< number made by the generators
  double alpha = 0.01;
  bool deadline = true;  ///< false: every pair refined to its end
  bool paced = false;
  std::uint64_t frames = 1, warm_up = 0;
  std::optional<std::uint64_t> budget_work;  ///< without a deadline: node-pair expansions of a frame
  bool islands_wait = true;                  ///< as the scene says; false: never
  bool sleeping = false;                     ///< as the scene says; true: always
  std::optional<std::uint64_t> reference_every;
};

/// What a run takes besides the times of its frames.
struct StudyRunCost {
  double load_ms = 0;  ///< reading meshes, building or reading trees, adding the bodies of the start
  /// Growth of the largest resident memory of the process, without the reports of the frames; 0 where the system does
  /// not say. Right only for the first run of a process: later ones use memory that earlier ones have left.
  std::uint64_t memory_bytes = 0;
};

/// Runs a scene repeatedly, each time from its start. Invariant: the scene was read, and has generators.
class StudyScene {
 public:
  /// Refused as by poise run, and: a scene without generators, since its population cannot be chosen.
  static Result<StudyScene> make(const StudyTimesOptions& options, const std::string& default_scene);
  /// The frames of one run, warm-up included. Refused: as the scene's run, and after Ctrl-C.
  Result<std::vector<simulation::RunFrame>> run(const StudyRun& run, const std::string& doing, Progress& progress,
                                                StudyRunCost* cost = nullptr) const;
  /// What a run of the scene starts with.
  [[nodiscard]] SceneRunOptions start_options() const;
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const std::string& name() const { return scene_.name; }
  [[nodiscard]] double deadline_ms() const;
  [[nodiscard]] int threads() const;

 private:
  StudyScene() = default;
  Scene scene_;
  StudyTimesOptions options_;
};

/// A table with machine and build set.
io::StudyTable begin_study(const std::string& name, const std::string& command);
/// Writes the requested outputs; the picture has the charts in rows of so many. The JSON has the charts too, for
/// `poise study draw`.
Status write_study(const StudyTimesOptions& options, const io::StudyTable& table, std::vector<LineChart> charts,
                   std::size_t columns);
/// The same with a picture that a script for gnuplot draws.
Status write_study(const StudyTimesOptions& options, const io::StudyTable& table, std::vector<LineChart> charts,
                   const std::string& plot, std::size_t columns = 2);

}  // namespace poise::app
