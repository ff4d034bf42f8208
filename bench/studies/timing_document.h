// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/made_by.h"

namespace poise::io {

/// Where and by what something was measured.
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
  double candidate_pairs = 0, contacts = 0;  ///< medians of the frames that were timed
  std::uint64_t frames = 0;
  [[nodiscard]] double ns_per_body() const { return bodies > 0 ? 1e6 * stage_ms / static_cast<double>(bodies) : 0; }
  [[nodiscard]] double ns_per_pair() const { return candidate_pairs > 0 ? 1e6 * stage_ms / candidate_pairs : 0; }
};
struct CostDocument {
  std::string scene;
  double period_ms = 0;
  std::vector<CostRow> rows;  ///< stages of a population and state follow each other; the last one is "all of these"
  MeasuredBy by;
};
/// `poise.cost/1`, and tables for docs.
std::string cost_json(const CostDocument& document);
std::string cost_markdown(const CostDocument& document);

/// A stage of frames that have what the frames before found out, and of frames that have nothing: medians.
struct CacheRow {
  std::string stage;
  double cached_ms = 0, anew_ms = 0;
  [[nodiscard]] double share() const { return anew_ms > 0 ? cached_ms / anew_ms : 0; }
};
struct CacheDocument {
  std::string scene;
  std::uint64_t bodies = 0;
  std::uint64_t frames_retained = 0, frames_anew = 0;
  double cached_pairs = 0;                      ///< that needed no refinement, a frame
  double levels_retained = 0, levels_anew = 0;  ///< completed a frame
  std::vector<CacheRow> rows;                   ///< the last two: finding pairs and refining them, and all stages
  MeasuredBy by;
  /// What a kept pair saves of finding and refining.
  [[nodiscard]] double saved_ns_per_pair() const {
    return cached_pairs > 0 && rows.size() > 1
               ? 1e6 * (rows[rows.size() - 2].anew_ms - rows[rows.size() - 2].cached_ms) / cached_pairs
               : 0;
  }
};
/// `poise.cache/1`, and a table for docs.
std::string cache_json(const CacheDocument& document);
std::string cache_markdown(const CacheDocument& document);

/// Refinement on a number of threads.
struct ScalingRow {
  int threads = 1;
  double units_per_us = 0;  ///< node-pair expansions, median over frames
  double p10 = 0, p90 = 0;  ///< of the same
  double times_one = 0;     ///< over the same with the first number of threads
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

/// What one feature costs a step in executed instructions, off and on.
struct FreeRow {
  std::string feature, off_options, on_options;
  double off_instructions = 0, on_instructions = 0;  ///< a step, mean
  bool absent = false;                               ///< not in this program; nothing else is said
  std::vector<std::string>
      called_off;                ///< functions of the feature that were called though it is off; has none to be right
  std::size_t functions_on = 0;  ///< functions of the feature that are called when it is on
  bool inside_kernels = false;   ///< it has no functions of its own to look for
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

}  // namespace poise::io
