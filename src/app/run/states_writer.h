// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "app/run/body_table.h"
#include "app/run/states_file.h"
#include "poise/result.h"
#include "poise/scene/scene.h"
#include "scene/run/numbered_states.h"

namespace poise::app {

/// What `--states FILE` writes: the table of states, and that of bodies beside it. Without the option it does nothing.
/// Invariant: neither file has its name before finish(); the states of a program that is killed are in a part
/// (StatesFile).
class StatesWriter {
 public:
  /// Refused: files that cannot be written.
  static Result<StatesWriter> open(const std::string& path, StatesFile::WrittenBy by = StatesFile::WrittenBy::Caller);
  [[nodiscard]] bool on() const { return file_.has_value(); }
  /// States after a frame, of the start as frame 0, `time_s` later than it; the bodies are those of `run` now.
  Status add(const Scene& scene, const SceneRun& run, std::uint64_t frame, double time_s,
             std::span<const io::NumberedState> states);
  /// Both files. Refused: what could not be written, now or before; the states then end with the last frame that was
  /// written whole.
  Status finish();

 private:
  std::optional<StatesFile> file_;
  BodyTable bodies_;
};

}  // namespace poise::app
