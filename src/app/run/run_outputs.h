// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>

#include "app/capture/run_capture.h"
#include "app/process/progress.h"
#include "app/report/report_files.h"
#include "app/run/run_loop.h"
#include "app/run/run_options.h"
#include "app/run/run_record.h"
#include "app/run/states_writer.h"
#include "poise/scene/scene.h"
#include "scene/result_file.h"
#include "scene/run/requirement.h"
#include "scene/run/run_document.h"

namespace poise::app {

/// The files of a run, opened before it starts so that a bad path is told at once. Each is on its own: what goes wrong
/// with one is told and takes nothing from the others. Only record, states and capture are seen before the end.
struct RunOutputs {
  ReportFiles report;  ///< of all frames, after the run
  std::optional<io::AtomicFile> json, frames_csv, picture, trace;
  StatesWriter states;
  RunRecord record;
  RunCapture capture;

  /// Refused: all that cannot be written, in one message; then no file is left behind.
  static Result<RunOutputs> open(const RunOptions& options);
};

/// The sinks of a run, of which one that cannot be written any more gets a warning and is left out from then on. Of
/// what another thread writes (a capture, the states of a paced run) that is told with a frame that follows.
struct RunSinks {
  StatesSink states;
  RecordSink record;
  CaptureSink capture;
};
RunSinks sinks_of(const Scene& scene, const SceneRun& run, const LoopSettings& loop, RunOutputs& outputs,
                  Progress& progress);

/// A run that has ended.
struct EndedRun {
  const RunOptions& options;
  const io::Requirement& requirement;
  const Scene& scene;
  SceneRun& run;
  const LoopSettings& loop;
  const LoopResult& result;
  const Trace* trace;  ///< may be null
};

/// Closes what was written during the run, then writes the JSON, then all that is made of it, and the table. `document`
/// gets what its capture came to, and which requirements do not hold. Refused: all that could not be written, in one
/// message; the rest is written.
Status write_results(const EndedRun& ended, io::RunDocument& document, RunOutputs& outputs);

}  // namespace poise::app
