// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/capture_writer.h"
#include "capture/observe.h"
#include "poise/scene/scene.h"
#include "scene/run/run_document.h"

namespace poise::app {

/// The options of `poise run` and `poise replay` that concern captures.
struct CaptureOptions {
  std::string file;
  bool contacts = false;
  bool pairs = false;
  std::optional<double> step_m;
};
void add_capture_options(CLI::App& command, CaptureOptions& options);
/// Refused: options that need --capture without it, and the standard output.
Status check_capture_options(const CaptureOptions& options);

/// The capture of a run as it is made; without `--capture` it does nothing.
class RunCapture {
 public:
  /// Whether frames for which the writer has no room are left out; otherwise the run waits for it.
  enum class WhenFull : std::uint8_t { LeaveOut, Wait };

  /// Makes the writer's thread. Without begin() no file is left behind that was not there. Refused: a file that cannot
  /// be written.
  static Result<RunCapture> open(const CaptureOptions& options);
  /// Follows a run before begin(): before its first frame, and after each that is not captured.
  void watch(const Scene& scene, SceneRun& run);
  void pass();
  /// Before the first frame: `scene` and `run` are observed until finish(). The header is complete but for the steps
  /// and what the options say. Writes the frame at hand: the start, frame 0, unless `first` says of which step it is.
  Status begin(const Scene& scene, SceneRun& run, capture::CaptureHeader header, WhenFull when_full,
               const std::optional<capture::FrameFacts>& first = {});
  /// After a step, with what is said of it beside its bodies. Refused: a frame before that could not be written.
  Status frame(capture::FrameFacts facts);
  /// Writes what is left. Refused: what could not be written since begin().
  Status finish(bool stopped);

  [[nodiscard]] bool on() const { return writer_.has_value(); }
  [[nodiscard]] bool begun() const { return run_ != nullptr; }
  /// After finish(); empty without a capture.
  [[nodiscard]] std::optional<io::RunDocument::Capture> facts() const;

 private:
  /// Refused: a body farther away than steps can say.
  [[nodiscard]] Status within_reach(const capture::SeenFrame& frame) const;

  CaptureOptions options_;
  std::optional<capture::CaptureWriter> writer_;
  std::optional<capture::FrameObserver> observer_;
  const SceneRun* run_ = nullptr;
  double reach_m_ = 0;       ///< of the steps in which positions are written
  Status reached_ = Done{};  ///< refused: a body was beyond it
  std::optional<capture::CapturedCamera> camera_;
  WhenFull when_full_ = WhenFull::Wait;
};

/// The words of this program's command line; empty where the system does not tell.
std::vector<std::string> command_line();

}  // namespace poise::app
