// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/picture/frame_picture.h"
#include "app/replay/replay_loop.h"
#include "app/replay/replay_options.h"
#include "app/report/report_files.h"
#include "scene/result_file.h"

namespace poise::app {

/// What a replay makes for looking at: a capture, a page, pictures. Without their options it does nothing. It observes
/// the replay that is given to begin() for as long as it lives.
class ReplayFiles {
 public:
  /// Tries all files before the replay. Refused: what cannot be written, a page that is not built.
  static Result<ReplayFiles> open(const ReplayOptions& options);
  /// Before the first frame. Refused: as the capture refuses.
  Status begin(const io::RecordHeader& record, const Scene& scene, SceneRun& run);
  [[nodiscard]] ReplayCapture capture_sink();
  [[nodiscard]] ReplayPicture picture_sink();
  /// After the last frame. Refused: what could not be written; frames from A on that the record does not have.
  Status finish(const ReplayResult& result);
  /// What was made, as lines for people.
  [[nodiscard]] std::string told() const;

 private:
  ReplayFiles(const ReplayOptions& options, RunCapture capture, ReportFiles report);
  Status begin_capture(const std::optional<capture::FrameFacts>& first);
  Status captured(const FrameReport& report, const io::RecordedFrame& recorded);
  Status drawn(std::uint64_t frame);

  ReplayOptions options_;
  FrameRange frames_;
  RunCapture capture_;
  ReportFiles report_;
  FilmFrames film_;
  Status film_written_ = Done{};  ///< the last picture of the film
  std::optional<io::AtomicFile> picture_;
  std::optional<io::FramePictures> pictures_;  // none: nothing is drawn
  const io::RecordHeader* record_ = nullptr;
  const Scene* scene_ = nullptr;
  SceneRun* run_ = nullptr;
  std::vector<simulation::RunFrame> charted_;  // for the chart of the report
};

}  // namespace poise::app
