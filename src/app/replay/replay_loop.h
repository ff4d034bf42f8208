// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

#include "poise/scene/scene.h"
#include "record/explain_document.h"
#include "record/record_file.h"
#include "scene/run/numbered_states.h"

namespace poise::app {

/// How a record is done again.
struct ReplaySettings {
  std::optional<std::uint64_t> frames;        ///< at most so many
  std::optional<std::uint64_t> explain;       ///< a frame by its number from 0; the replay ends with it
  std::stop_token stop = {};                  ///< asks it to end after the frame at hand
  std::optional<std::uint64_t> reasons_from;  ///< from this frame on: scores and reasons of all pairs, for a capture
};

struct ReplayResult {
  std::uint64_t frames = 0;              ///< done again
  std::uint64_t state_hash = 0;          ///< after them
  std::optional<std::uint64_t> differs;  ///< the first frame after which the state is another; the replay ends there
  std::uint64_t recorded_hash = 0;       ///< after that frame
  std::optional<io::RecordReader::Damage> damage;  ///< where the record cannot be read on
  bool at_end = false;                             ///< the record's end was reached
  bool run_stopped = false;                        ///< with at_end: the recorded run was stopped by Ctrl-C
  bool stopped = false;                            ///< the replay was
  std::optional<io::ExplainedFrame> explained;
};

/// Told the states after each frame, and of the start as frame 0.
using ReplayStates = std::function<Status(std::uint64_t frame, std::span<const io::NumberedState> states)>;
/// Told each frame and what its record says, for a capture, while the World stands as the frame left it.
using ReplayCapture = std::function<Status(const FrameReport& report, const io::RecordedFrame& recorded)>;
/// Told how many frames are done, of how many.
using ReplayProgress = std::function<void(std::uint64_t done, std::uint64_t of)>;
/// Told each frame while the World stands as the frame left it, and the start as frame 0; after the others.
using ReplayPicture = std::function<Status(std::uint64_t frame)>;

/// Who is told of a replay; each may be empty.
struct ReplaySinks {
  ReplayStates states = {};
  ReplayCapture capture = {};
  ReplayPicture picture = {};
  ReplayProgress progress = {};
};

/// What the World of a replay is made with: as recorded, on `threads` threads (0 = all) of `executor`, with the room
/// for fronts that the recorded threads had together.
WorldSettings replay_world(const io::RecordHeader& header, ExecutorKind executor, int threads);

/// Does the frames of a record again, each with what was decided in it. Refused: what the World, the scene or a sink
/// refuses.
Result<ReplayResult> replay_loop(io::RecordReader& record, const Scene& scene, SceneRun& run,
                                 const ReplaySettings& settings, const ReplaySinks& sinks);

}  // namespace poise::app
