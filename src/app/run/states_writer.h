// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/run/body_table.h"
#include "poise/result.h"
#include "poise/scene/scene.h"
#include "scene/result_file.h"
#include "scene/run/numbered_states.h"

namespace poise::app {

/// What `--states FILE` writes: the table of states, and that of bodies beside it. Without the option it does nothing.
/// Invariant: neither file is there before finish(). The states of a program that is killed are in `.NAME.N.part`, up
/// to a quarter of a second before.
class StatesWriter {
 public:
  /// Refused: files that cannot be written.
  static Result<StatesWriter> open(const std::string& path);
  [[nodiscard]] bool on() const { return file_.has_value(); }
  /// States after a frame, of the start as frame 0, `time_s` later than it; the bodies are those of `run` now. With
  /// `wait` they are written by finish(), since writing would eat the time between paced frames.
  Status add(const Scene& scene, const SceneRun& run, std::uint64_t frame, double time_s,
             std::span<const io::NumberedState> states, bool wait = false);
  /// Both files. Refused: what could not be written, now or before; the states then end with the last frame that was
  /// written whole.
  Status finish();

 private:
  struct Waiting {
    std::uint64_t frame = 0;
    double time_s = 0;
    std::vector<io::NumberedState> states;
  };
  Status write(std::uint64_t frame, double time_s, std::span<const io::NumberedState> states);

  std::optional<io::AtomicFile> file_;
  BodyTable bodies_;
  std::string text_;
  std::chrono::steady_clock::time_point flushed_;
  std::vector<Waiting> waiting_;
};

}  // namespace poise::app
