// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "poise/decisions.h"
#include "poise/world.h"
#include "scene/made_by.h"

/// The content of a record of a run (docs/record.md), as plain values. For the file see record_file.h, for hashes of
/// shapes record_shapes.h.
namespace poise::io {

/// A file that a shape was loaded from.
struct RecordedFile {
  std::string path;  ///< as in the scene file
  std::uint64_t bytes = 0;
  std::uint64_t hash = 0;  ///< xxHash64 of its bytes
};

/// A shape as it was loaded.
struct RecordedShape {
  std::string name;
  std::vector<RecordedFile> files;
  std::uint64_t hash = 0;  ///< of the resulting tree and mass properties
};

/// Data that a replay needs before the first frame, and information on the run.
struct RecordHeader {
  std::string scene_name;
  std::string scene_source;             ///< the file, for messages
  std::string scene_folder;             ///< folder that its relative files were relative to, absolute
  std::string scene_text;               ///< the whole scene file
  std::optional<std::uint64_t> bodies;  ///< SceneRunOptions::bodies
  std::optional<std::uint64_t> seed;    ///< SceneRunOptions::seed
  std::vector<RecordedShape> shapes;    ///< in the order of SceneRun::shapes
  std::optional<std::string> gaze;      ///< the text of a recorded gaze: of the scene's file, or one given for the run
  bool gaze_loop = false;               ///< SceneGaze::loop of it
  std::uint64_t start_hash = 0;         ///< World::state_hash before the first frame

  WorldSettings world;  ///< gravity and seed are the scene's; executor, threads and capacities are the run's
  double dt_s = 0;
  Level max_level = kMaxTreeDepth;
  bool polygons = false;
  bool backtracking = false;

  std::uint64_t frames = 0;  ///< requested number, warm-up included
  std::string clock;         ///< `wall` or `work`
  bool paced = false;
  double deadline_ms = 0;  ///< wall clock
  std::optional<std::uint64_t> budget_work;
  Machine machine;
  BuildFacts build;
};

/// Times of a frame under a deadline, for information.
struct RecordedTimes {
  MissCause cause = MissCause::None;
  Nanoseconds release_delay{0};            ///< FrameReport::release_delay
  Nanoseconds host{0};                     ///< FrameReport::host_actual
  StageTimes stages;                       ///< without the total
  Nanoseconds piece{0};                    ///< FrameReport::longest_job
  std::uint32_t piece_a = 0, piece_b = 0;  ///< slots of its bodies
};

/// One frame of a record.
struct RecordedFrame {
  FrameDecisions decisions;
  std::uint64_t state_hash = 0;        ///< after the frame
  std::optional<RecordedTimes> times;  ///< empty with counted work
  // Of the wall clock, for information; 0 with counted work.
  Nanoseconds budget{0};            ///< FrameReport::budget
  Nanoseconds refine_available{0};  ///< FrameReport::refine_available
  Nanoseconds reserve{0};           ///< FrameReport::reserve_at_cut
  Nanoseconds lateness{0};          ///< FrameReport::lateness
};

/// The end of a record.
struct RecordEnd {
  std::uint64_t frames = 0;  ///< number of frames in the record
  bool stopped = false;      ///< by Ctrl-C or SIGTERM
};

}  // namespace poise::io
