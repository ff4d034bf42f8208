// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "app/capture/run_capture.h"
#include "app/options/frame_range.h"
#include "app/options/tree_cache_options.h"
#include "app/picture/picture_options.h"
#include "poise/result.h"

namespace poise::app {

/// Rows of each list of --explain by default.
inline constexpr std::uint64_t kExplainedRows = 20;

/// The command line of `poise replay`, each value in its range, not yet checked against each other.
struct ReplayOptions {
  std::string record, files, executor, json, states, frames;
  std::string report;  ///< a folder
  std::optional<std::uint64_t> threads, explain, limit, frame, frames_every;
  CaptureOptions capture;
  PictureOptions picture;
  TreeCacheOptions tree_cache;
  bool quiet = false;
};

/// Declares the options on a subcommand.
void add_replay_options(CLI::App& command, ReplayOptions& options);
/// Refused: options that contradict each other, as one line.
Status check_replay_options(const ReplayOptions& options);
/// Refuses an output into a file that the scene of the record names.
Status check_replay_files(const ReplayOptions& options, const Scene& scene);
/// The frames that are captured and drawn; the replay ends with the last of them. Frame 0 is the start. Refused: what
/// --frames may not be.
Result<FrameRange> replayed_frames(const ReplayOptions& options);

}  // namespace poise::app
