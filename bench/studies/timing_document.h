// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/report/line_chart.h"
#include "scene/made_by.h"

namespace poise::io {

/// Machine, build and settings of a measurement.
struct MeasuredBy {
  Machine machine;
  BuildFacts build;
  int threads = 1;
  std::string executor;
};

/// One mandatory stage of one population in one state: medians over frames.
struct CostRow {
  std::uint64_t bodies = 0;
  bool settled = false;
  std::string stage;
  double stage_ms = 0;
  double candidate_pairs = 0, contacts = 0;  ///< medians over the timed frames
  std::uint64_t frames = 0;
  [[nodiscard]] double ns_per_body() const { return bodies > 0 ? 1e6 * stage_ms / static_cast<double>(bodies) : 0; }
  [[nodiscard]] double ns_per_pair() const { return candidate_pairs > 0 ? 1e6 * stage_ms / candidate_pairs : 0; }
};
struct CostDocument {
  std::string scene;
  double period_ms = 0;
  std::vector<CostRow> rows;  ///< stages of a population and state are consecutive; the last one is "all of these"
  MeasuredBy by;
};
/// `poise.cost/1`, tables for docs, and what the page of the study draws; so it is of the other documents.
std::string cost_json(const CostDocument& document);
std::string cost_markdown(const CostDocument& document);
std::vector<app::LineChart> cost_charts(const CostDocument& document);

/// A stage in frames with cached data of earlier frames, and in frames without: medians.
struct CacheRow {
  std::string stage;
  double cached_ms = 0, anew_ms = 0;
  [[nodiscard]] double share() const { return anew_ms > 0 ? cached_ms / anew_ms : 0; }
};
struct CacheDocument {
  std::string scene;
  std::uint64_t bodies = 0;
  std::uint64_t frames_retained = 0, frames_anew = 0;
  double cached_pairs = 0;                      ///< number that needed no refinement, a frame
  double levels_retained = 0, levels_anew = 0;  ///< number completed a frame
  std::vector<CacheRow> rows;                   ///< the last two: finding and refining pairs, and all stages
  MeasuredBy by;
  /// Time of finding and refining that a cached pair saves.
  [[nodiscard]] double saved_ns_per_pair() const {
    return cached_pairs > 0 && rows.size() > 1
               ? 1e6 * (rows[rows.size() - 2].anew_ms - rows[rows.size() - 2].cached_ms) / cached_pairs
               : 0;
  }
};
/// `poise.cache/1`, and a table for docs.
std::string cache_json(const CacheDocument& document);
std::string cache_markdown(const CacheDocument& document);
std::vector<app::LineChart> cache_charts(const CacheDocument& document);

/// Refinement on a number of threads.
struct ScalingRow {
  int threads = 1;
  double units_per_us = 0;  ///< node-pair expansions, median over frames
  double p10 = 0, p90 = 0;  ///< percentiles of the same
  double times_one = 0;     ///< ratio to the same with the first number of threads
  std::uint64_t frames = 0;
};
struct ScalingDocument {
  std::string scene;
  std::uint64_t bodies = 0;
  double units_a_frame = 0;  ///< expansions, median
  std::vector<ScalingRow> rows;
  MeasuredBy by;
};
std::string scaling_json(const ScalingDocument& document);
std::string scaling_markdown(const ScalingDocument& document);
std::vector<app::LineChart> scaling_charts(const ScalingDocument& document);

/// Work and critical path of one stage in one state: medians over frames, each figure by itself.
struct SpanRow {
  bool settled = false;
  std::string stage;
  double work_ms = 0;
  double serial_ms = 0;    ///< of it outside parallel loops
  double span_ms = 0;      ///< serial, and the longest chunk of each loop
  double on_cores_ms = 0;  ///< serial, and the time of each loop on SpanDocument::cores
  double loops = 0;
  std::uint64_t frames = 0;
  [[nodiscard]] double parallelism() const { return span_ms > 0 ? work_ms / span_ms : 0; }
  [[nodiscard]] double times_faster() const { return on_cores_ms > 0 ? work_ms / on_cores_ms : 0; }
};
struct SpanDocument {
  std::string scene;
  std::uint64_t bodies = 0;
  int cores = 16;
  std::vector<SpanRow> rows;  ///< stages of a state are consecutive; the last one is "all of these"
  MeasuredBy by;
};
/// `poise.span/1`, and a table for docs.
std::string span_json(const SpanDocument& document);
std::string span_markdown(const SpanDocument& document);
std::vector<app::LineChart> span_charts(const SpanDocument& document);

/// Instructions of one feature in a step, off and on.
struct FreeRow {
  std::string feature, off_options, on_options;
  double off_instructions = 0, on_instructions = 0;  ///< mean of a step
  bool absent = false;                               ///< not in this program; the other figures are undefined
  std::vector<std::string> called_off;  ///< functions of the feature that were called although it is off; must be empty
  std::size_t functions_on = 0;         ///< functions of the feature that are called when it is on
  bool inside_kernels = false;          ///< the feature has no functions of its own to search for
  [[nodiscard]] bool ok() const { return absent || inside_kernels || (called_off.empty() && functions_on > 0); }
};
struct FreeDocument {
  std::string counted_by;
  std::uint64_t frames = 0;
  std::vector<FreeRow> rows;
  MeasuredBy by;
};
std::string free_json(const FreeDocument& document);
std::string free_markdown(const FreeDocument& document);
std::vector<app::LineChart> free_charts(const FreeDocument& document);

}  // namespace poise::io
