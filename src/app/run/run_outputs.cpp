// SPDX-License-Identifier: MIT
#include "app/run/run_outputs.h"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "app/files/output_files.h"
#include "app/picture/drawn_frame.h"
#include "app/picture/frame_picture.h"
#include "app/picture/picture.h"
#include "app/process/refusal.h"
#include "app/process/standard_streams.h"
#include "app/process/until_it_fails.h"
#include "app/run/run_table.h"
#include "app/run/run_trace.h"
#include "capture/observe.h"
#include "scene/run/run_tables.h"

namespace poise::app {
namespace {

StatesSink states_sink(const Scene& scene, const SceneRun& run, const LoopSettings& loop, StatesWriter& states) {
  if (!states.on()) return {};
  return [&](std::uint64_t frame, std::span<const io::NumberedState> now) {
    return states.add(scene, run, frame, static_cast<double>(frame) * loop.dt_s, now);
  };
}

CaptureSink capture_sink(const SceneRun& run, double dt_s, RunCapture& capture) {
  if (!capture.on()) return {};
  return [&run, dt_s, &capture](const simulation::RunFrame& frame) {
    capture::FrameFacts facts = capture::facts_of(frame.report, run.view(), dt_s);
    facts.warm_up = frame.warm_up;
    facts.kinetic_j = frame.report.kinetic_j;
    facts.potential_j = frame.report.potential_j;
    facts.momentum_ns = capture::captured_momentum(frame.report.momentum_ns);
    return capture.frame(facts);
  };
}

std::string frames_text(const LoopResult& result, double dt_s) {
  std::string text = io::frames_header();
  for (std::size_t i = 0; i < result.frames.size(); ++i) {
    io::append_frame(result.frames[i], static_cast<double>(i + 1) * dt_s, text);
  }
  return text;
}

Status write_whole(io::AtomicFile& file, const std::string& text) {
  const Status written = file.write(text);
  return written ? file.commit() : written;
}

Status write_json(const RunOptions& options, const io::RunDocument& document, std::optional<io::AtomicFile>& file) {
  if (options.json.empty()) return Done{};
  const std::string text = io::run_json(document);
  return options.json == "-" ? io::write_stdout(text) : write_whole(*file, text);
}

Status print_table(const RunOptions& options, const io::RunDocument& document) {
  if (options.quiet) return Done{};
  std::string table = run_table(document);
  if (!options.report.empty()) table += fmt::format("report         {}\n", report_page_of(options.report));
  if (options.json != "-") return io::write_stdout(table);
  print_error("{}", table);
  return Done{};
}

Status write_picture(const RunOptions& options, const Scene& scene, SceneRun& run, std::uint64_t frame,
                     io::AtomicFile& file) {
  const Result<io::DrawnFrame> drawn = io::drawn_frame(scene, run, frame, static_cast<double>(frame) * scene.dt_s);
  if (!drawn) return drawn.error();
  const io::FramePictures pictures(capture::captured_shapes(scene, run), picture_settings(options.picture));
  const Result<std::string> png = io::png_bytes(pictures.draw(drawn.value()));
  if (!png) return png.error();
  return write_whole(file, png.value());
}

Status write_spans(const EndedRun& ended, io::AtomicFile& file) {
  if (ended.trace->discarded() > 0)
    print_error("poise run: warning: --trace: {} spans beyond the first {} were left out\n", ended.trace->discarded(),
                kTraceRoom);
  return write_trace(file, ended.scene.name, ended.run.world().threads(), *ended.trace, ended.result.traced_pairs,
                     ended.result.frames);
}

}  // namespace

Result<RunOutputs> RunOutputs::open(const RunOptions& options) {
  // First, since it makes the folder in which the capture may lie.
  Result<ReportFiles> report = ReportFiles::open(options.report);
  Status all = report ? Status(Done{}) : Status(report.error());
  std::optional<io::AtomicFile> json = open_file(options.json, all);
  // More than any has, so that the figures of a run are there when its other files have filled the disk.
  constexpr std::uint64_t kBytesOfJson = 1U << 17U;
  if (json) json->reserve(kBytesOfJson);
  std::optional<io::AtomicFile> frames_csv = open_file(options.frames_csv, all);
  std::optional<io::AtomicFile> picture = open_file(options.picture.file, all);
  std::optional<io::AtomicFile> trace = open_file(options.trace, all);
  Result<StatesWriter> states = StatesWriter::open(
      options.states, options.paced ? StatesFile::WrittenBy::OwnThread : StatesFile::WrittenBy::Caller);
  if (!states) add_failure(states.error(), all);
  Result<RunRecord> record = RunRecord::open(options.record);
  if (!record) add_failure(record.error(), all);
  Result<RunCapture> capture = RunCapture::open(options.capture);
  if (!capture) add_failure(capture.error(), all);
  if (!all) return all.error();
  return RunOutputs{std::move(report).value(), std::move(json),           std::move(frames_csv),
                    std::move(picture),        std::move(trace),          std::move(states).value(),
                    std::move(record).value(), std::move(capture).value()};
}

RunSinks sinks_of(const Scene& scene, const SceneRun& run, const LoopSettings& loop, RunOutputs& outputs,
                  Progress& progress) {
  RunSinks sinks;
  sinks.states = until_it_fails("run", states_sink(scene, run, loop, outputs.states), progress);
  sinks.record = until_it_fails("run", outputs.record.sink(run), progress);
  sinks.capture = until_it_fails("run", capture_sink(run, loop.dt_s, outputs.capture), progress);
  return sinks;
}

Status write_results(const EndedRun& ended, io::RunDocument& document, RunOutputs& outputs) {
  const std::vector<simulation::RunFrame>& frames = ended.result.frames;
  Status all = Done{};
  add_failure(outputs.record.finish(ended.result.stopped), all);
  const Status captured = outputs.capture.finish(ended.result.stopped);
  add_failure(captured, all);
  if (captured) document.capture = outputs.capture.facts();
  document.requirements_failed = io::failed_comparisons(ended.requirement, io::named_figures(document));
  // The figures first: all that follows takes longer, and says less.
  add_failure(write_json(ended.options, document, outputs.json), all);
  add_failure(outputs.states.finish(), all);
  if (outputs.frames_csv)
    add_failure(write_whole(*outputs.frames_csv, frames_text(ended.result, ended.loop.dt_s)), all);
  if (ended.trace != nullptr) add_failure(write_spans(ended, *outputs.trace), all);
  if (outputs.picture)
    add_failure(write_picture(ended.options, ended.scene, ended.run, frames.size(), *outputs.picture), all);
  if (!ended.options.report.empty()) {
    add_failure(
        outputs.report.write(document, frames, frames_text(ended.result, ended.loop.dt_s), ended.options.capture.file),
        all);
  }
  add_failure(print_table(ended.options, document), all);
  return all;
}

}  // namespace poise::app
