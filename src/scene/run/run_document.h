// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "poise/scene/scene.h"
#include "scene/made_by.h"
#include "scene/run/run_report.h"

namespace poise::io {

/// The content of the result file of a run (docs/run-report.md).
struct RunDocument {
  std::string scene;
  std::string scene_file;
  std::size_t bodies = 0;  ///< at the end, static ones and planes included
  std::size_t dynamic_bodies = 0;
  std::size_t dynamic_bodies_max = 0;  ///< in any frame; more than at the end where bodies leave
  std::uint64_t frames_asked = 0;      ///< requested number, without warm-up
  bool stopped = false;                ///< by Ctrl-C or SIGTERM
  double dt_s = 0;
  std::uint64_t seed = 0;
  int threads = 0;
  std::string executor, policy, contact, clock;
  scheduler::Policy policy_weights;
  std::vector<int> affinity;  ///< processors that the threads were bound to, in order; empty: none
  int realtime_priority = 0;  ///< 0: none
  double spin_us = 0;
  bool paced = false;
  std::optional<double> deadline_ms;
  double host_work_ms = 0;  ///< reserved time, unless it is learned
  bool host_work_learned = false;
  double render_load_ms = 0, render_load_jitter_ms = 0;
  double alpha = 0.01;                   ///< WorldSettings::alpha
  std::uint64_t time_priors_frames = 0;  ///< frames of earlier runs in the initial time forecasts; 0: none
  std::optional<std::uint64_t> budget_work;
  int max_level = 0;
  bool polygons = false;
  bool backtracking = false;
  bool sleeping = false;
  IslandsWait islands_wait = IslandsWait::Any;
  std::optional<std::uint64_t> reference_every;
  double tray_side_m = 0;
  Machine machine;
  BuildFacts build;
  simulation::RunFigures figures;
  std::string record;  ///< file of the run's record; empty: none
  /// The capture of the run.
  struct Capture {
    std::string file;
    std::uint64_t frames = 0, left_out = 0;
    std::uint64_t bytes = 0;
  };
  std::optional<Capture> capture;
  Conserved start, end;
  double energy_max_j = 0;  ///< largest sum of kinetic and potential energy, at the start and after any measured frame
  std::uint64_t state_hash = 0;
  /// Mesh, tree and sphere-list shapes: from the origin of the shape to its centre of mass.
  std::vector<std::pair<std::string, Vec3>> origin_offsets_m;
  std::vector<std::string> warnings;  ///< SceneRun::warnings
  TreeCacheUse tree_cache_use;
  std::vector<std::string> requirements_failed;
  std::optional<std::string> requirement;
};

/// A number of the document with its dotted path; empty if the run does not define it.
struct NamedFigure {
  std::string name;
  std::optional<double> value;
};

/// The document as `poise.run/2` JSON, numbers with full precision, ending in a newline.
std::string run_json(const RunDocument& document);

/// Every number (and undefined number) of the document in its order, then the names that it has only with late frames
/// or a capture, undefined where it has none, and `miss_rate` for `misses.rate`. So the names of a run are known before
/// it.
std::vector<NamedFigure> named_figures(const RunDocument& document);

}  // namespace poise::io
