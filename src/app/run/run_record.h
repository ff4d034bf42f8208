// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

#include "app/run/run_loop.h"
#include "app/run/run_options.h"
#include "poise/scene/scene.h"
#include "record/record_file.h"

namespace poise::app {

/// The record of a run as it is made; without `--record` it does nothing.
class RunRecord {
 public:
  /// Refused: a file that cannot be written.
  static Result<RunRecord> open(const std::string& path);

  /// Before the first frame. `text` is the scene's file. Refused: a file of the scene that cannot be read any more, or
  /// the record cannot be written.
  Status begin(const RunOptions& options, const Scene& scene, const std::string& text, const SceneRun& run,
               const LoopSettings& loop);
  /// Told after each frame, outside of its time.
  RecordSink sink(const SceneRun& run);
  /// Gives the file its name.
  Status finish(bool stopped);
  [[nodiscard]] bool on() const { return writer_.has_value(); }

 private:
  std::optional<io::RecordWriter> writer_;
  io::RecordedFrame frame_;
  bool wall_clock_ = false;
};

}  // namespace poise::app
