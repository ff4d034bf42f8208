// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>

#include "app/report/box_chart.h"
#include "app/report/report_page.h"
#include "app/run/run_options.h"
#include "poise/result.h"
#include "scene/result_file.h"
#include "scene/run/run_document.h"

namespace poise::app {

/// The options of a run with those that `--report` brings along: a capture in its folder, unless another is named.
RunOptions with_report(RunOptions options);

/// The capture of a report, where no other is named.
std::string report_capture_of(const std::string& folder);
/// The page of a report; of an empty folder an empty name.
std::string report_page_of(const std::string& folder);

/// A run whose frames are charted.
struct ChartedRun {
  const std::string& scene;
  std::optional<double> deadline_ms;
  std::span<const simulation::RunFrame> frames;
};

/// What `--report FOLDER` writes beside the capture: the page, and its main charts as SVG and PNG.
class ReportFiles {
 public:
  /// Makes the folder and tries all its files, before the run; without `--report` it does nothing. Refused: a page that
  /// is not built, what cannot be written.
  static Result<ReportFiles> open(const std::string& folder);
  /// After the run, when its capture is complete.
  Status write(const io::RunDocument& document, std::span<const simulation::RunFrame> frames,
               const std::string& frames_csv, const std::string& capture);
  /// The page of a capture alone, and the charts of its frames. `command` is the name of the one that warns.
  Status write(const char* command, ReportParts parts, const std::string& capture, const ChartedRun& run);

 private:
  struct ChartFiles {
    std::string name;  ///< without an ending
    io::AtomicFile svg, png;
  };
  struct Files {
    std::string page;
    io::AtomicFile html;
    ChartFiles times, percentiles, levels;
  };
  static Result<ChartFiles> open_chart(const std::string& folder, const char* name);
  /// Without a chart, removes that of an earlier run, so that it is not taken for one of this run.
  static Status write_chart(const std::optional<BoxChart>& chart, ChartFiles& files);
  std::optional<Files> files_;
};

}  // namespace poise::app
