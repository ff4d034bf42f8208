// SPDX-License-Identifier: MIT
#include "app/report/report_files.h"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "app/capture/run_capture.h"
#include "app/files/output_files.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "app/report/frame_chart.h"
#include "app/report/report_page.h"
#include "app/report/report_template.h"

namespace poise::app {
namespace {

std::string in_folder(const std::string& folder, const char* name) {
  return (std::filesystem::path(folder) / name).string();
}

Status finish(io::AtomicFile& file, const std::string& text) {
  const Status written = file.write(text);
  return written ? file.commit() : written;
}

}  // namespace

RunOptions with_report(RunOptions options) {
  if (!options.report.empty() && options.capture.file.empty()) options.capture.file = report_capture_of(options.report);
  return options;
}

std::string report_capture_of(const std::string& folder) { return in_folder(folder, "run.capture"); }

std::string report_page_of(const std::string& folder) {
  return folder.empty() ? std::string() : in_folder(folder, "report.html");
}

Result<ReportFiles> ReportFiles::open(const std::string& folder) {
  ReportFiles made;
  if (folder.empty()) return made;
  Result<std::string> page = read_report_template();
  if (!page) return bad_input("--report: " + page.error().message);
  const Status there = make_folder("--report", folder);
  if (!there) return there.error();
  Result<io::AtomicFile> html = io::AtomicFile::open(report_page_of(folder));
  if (!html) return html.error();
  Result<ChartFiles> times = open_chart(folder, "frame-times");
  if (!times) return times.error();
  Result<ChartFiles> percentiles = open_chart(folder, "percentiles");
  if (!percentiles) return percentiles.error();
  Result<ChartFiles> levels = open_chart(folder, "levels");
  if (!levels) return levels.error();
  made.files_.emplace(Files{std::move(page).value(), std::move(html).value(), std::move(times).value(),
                            std::move(percentiles).value(), std::move(levels).value()});
  return made;
}

Result<ReportFiles::ChartFiles> ReportFiles::open_chart(const std::string& folder, const char* name) {
  const std::string path = in_folder(folder, name);
  Result<io::AtomicFile> svg = io::AtomicFile::open(path + ".svg");
  if (!svg) return svg.error();
  Result<io::AtomicFile> png = io::AtomicFile::open(path + ".png");
  if (!png) return png.error();
  return ChartFiles{path, std::move(svg).value(), std::move(png).value()};
}

Status ReportFiles::write_chart(const std::optional<BoxChart>& chart, ChartFiles& files) {
  if (!chart) {
    std::error_code ignored;
    for (const char* ending : {".svg", ".png"}) std::filesystem::remove(files.name + ending, ignored);
    return Done{};
  }
  Status written = finish(files.svg, chart_svg(*chart));
  const Result<std::string> png = io::png_bytes(chart_image(*chart));
  add_failure(png ? finish(files.png, png.value()) : Status(png.error()), written);
  return written;
}

Status ReportFiles::write(const io::RunDocument& document, std::span<const simulation::RunFrame> frames,
                          const std::string& frames_csv, const std::string& capture) {
  if (!files_) return Done{};
  return write("run", {command_line(), io::run_json(document), frames_csv, {}}, capture,
               {document.scene, document.deadline_ms, frames});
}

Status ReportFiles::write(const char* command, ReportParts parts, const std::string& capture, const ChartedRun& run) {
  if (!files_) return Done{};
  const Status embeds = check_capture_file(capture);
  if (embeds) {
    parts.captures.push_back(capture);
  } else {
    print_error("poise {}: warning: the report has no replay: {}\n", command, embeds.error().message);
  }
  Status written = write_report_page(files_->page, parts, files_->html);
  if (written) written = files_->html.commit();
  add_failure(write_chart(frame_chart(run.scene, run.deadline_ms, run.frames), files_->times), written);
  add_failure(write_chart(percentile_chart(run.scene, run.deadline_ms, run.frames), files_->percentiles), written);
  add_failure(write_chart(level_chart(run.scene, run.frames), files_->levels), written);
  return written;
}

}  // namespace poise::app
