// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "poise/result.h"
#include "scene/run/numbered_states.h"

namespace poise::app {

/// A table of states that is written while the run goes on. What there is of it is handed to the system four times a
/// second or every 256 kB. Invariant: it has its name only after finish(); until then it is `.NAME.N.part`, which a
/// program that is killed leaves, up to a quarter of a second before. At most a stated number of frames is held.
///
/// One thread uses it, the one that made it.
class StatesFile {
 public:
  /// Who makes the text and writes it: a paced run leaves that to another thread, which gives way to all others, since
  /// it would eat the time between frames.
  enum class WrittenBy : std::uint8_t { Caller, OwnThread };
  /// Frames that may wait for the other thread. Chosen: a quarter of a second of a usual game.
  static constexpr std::size_t kFramesWaiting = 16;

  /// The thread is made here, so that it runs where its maker may run now. Refused as OutputFailed: a path that cannot
  /// be written.
  static Result<StatesFile> open(const std::string& path, WrittenBy by);
  StatesFile(StatesFile&&) noexcept;
  StatesFile& operator=(StatesFile&&) noexcept;
  ~StatesFile();

  /// The states after a frame, `time_s` after the start, which is frame 0; `now` is when that is, and ascends. Waits
  /// while as many frames wait as may. Refused: what could not be written of this frame, or of one before.
  Status add(std::uint64_t frame, double time_s, std::span<const io::NumberedState> states,
             std::chrono::steady_clock::time_point now);
  /// Writes what is left and gives the file its name. Refused: what could not be written, now or before; the table then
  /// ends with the last frame that was written whole.
  Status finish();

 private:
  struct Impl;
  explicit StatesFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace poise::app
