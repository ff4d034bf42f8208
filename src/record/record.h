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

/// What a record of a run says (docs/record.md): values only. record_file.h has the file, record_shapes.h the hashes of
/// shapes.
namespace poise::io {

/// A file that a shape was loaded from.
struct RecordedFile {
  std::string path;  ///< as the scene writes it
  std::uint64_t bytes = 0;
  std::uint64_t hash = 0;  ///< xxHash64 of its bytes
};

/// A shape as it was loaded.
struct RecordedShape {
  std::string name;
  std::vector<RecordedFile> files;
  std::uint64_t hash = 0;  ///< of the tree and the mass properties that came of them
};

/// What a replay needs before the first frame, and what a person wants to know of the run.
struct RecordHeader {
  std::string scene_name;
  std::string scene_source;             ///< the file, for messages
  std::string scene_folder;             ///< what its relative files were relative to, absolute
  std::string scene_text;               ///< the whole scene file
  std::optional<std::uint64_t> bodies;  ///< SceneRunOptions::bodies
  std::optional<std::uint64_t> seed;    ///< SceneRunOptions::seed
  std::vector<RecordedShape> shapes;    ///< in the order of SceneRun::shapes
  std::uint64_t start_hash = 0;         ///< World::state_hash before the first frame

  WorldSettings world;  ///< gravity and seed are the scene's; executor, threads and room are those of the run
  double dt_s = 0;
  Level max_level = kMaxTreeDepth;
  bool polygons = false;
  bool backtracking = false;

  std::uint64_t frames = 0;  ///< asked for, warm-up included
  std::string clock;         ///< `wall` or `work`
  bool paced = false;
  double deadline_ms = 0;  ///< wall clock
  std::optional<std::uint64_t> budget_work;
  Machine machine;
  BuildFacts build;
};

/// One frame of a record.
struct RecordedFrame {
  FrameDecisions decisions;
  std::uint64_t state_hash = 0;  ///< after it
  // Of the wall clock, for people: 0 with counted work.
  Nanoseconds budget{0};            ///< FrameReport::budget
  Nanoseconds refine_available{0};  ///< FrameReport::refine_available
  Nanoseconds reserve{0};           ///< FrameReport::reserve_at_cut
  Nanoseconds lateness{0};          ///< FrameReport::lateness
};

/// What closes a record.
struct RecordEnd {
  std::uint64_t frames = 0;  ///< that the record holds
  bool stopped = false;      ///< by Ctrl-C
};

}  // namespace poise::io
