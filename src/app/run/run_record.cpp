// SPDX-License-Identifier: MIT
#include "app/run/run_record.h"

#include <utility>

#include "poise/time_arithmetic.h"
#include "record/record_shapes.h"

namespace poise::app {

Result<RunRecord> RunRecord::open(const std::string& path) {
  RunRecord record;
  if (path.empty()) return record;
  Result<io::RecordWriter> writer = io::RecordWriter::open(path);
  if (!writer) return writer.error();
  record.writer_ = std::move(writer).value();
  return record;
}

Status RunRecord::begin(const RunOptions& options, const Scene& scene, const std::string& text, const SceneRun& run,
                        const LoopSettings& loop) {
  if (!writer_) return Done{};
  Result<std::vector<io::RecordedShape>> shapes = io::recorded_shapes(scene, run.shapes());
  if (!shapes) return shapes.error();
  io::RecordHeader header;
  header.scene_name = scene.name;
  header.scene_source = scene.source;
  std::error_code ignored;
  header.scene_folder = std::filesystem::absolute(scene.base, ignored).lexically_normal().string();
  header.scene_text = text;
  if (scene.gaze && !scene.gaze->text.empty()) {
    header.gaze = scene.gaze->text;
    header.gaze_loop = scene.gaze->loop;
  }
  header.bodies = options.bodies;
  header.seed = options.seed;
  header.shapes = std::move(shapes).value();
  header.start_hash = run.world().state_hash();
  header.world = world_settings(options, scene);
  header.world.threads = run.world().threads();
  header.dt_s = loop.dt_s;
  header.max_level = loop.max_level;
  header.polygons = loop.polygons;
  header.backtracking = loop.backtracking;
  header.frames = loop.warm_up + loop.frames;
  header.clock = options.clock;
  header.paced = loop.paced;
  if (loop.wall_clock) header.deadline_ms = static_cast<double>(loop.deadline.count()) / 1e6;
  header.budget_work = loop.budget_work;
  header.machine = io::this_machine();
  header.build = io::this_build();
  wall_clock_ = loop.wall_clock;
  return writer_->begin(header);
}

RecordSink RunRecord::sink(const SceneRun& run) {
  if (!writer_) return {};
  return [this, &run](const FrameReport& report) -> Status {
    run.world().decisions(frame_.decisions);
    frame_.state_hash = run.world().state_hash();
    frame_.budget = report.budget;
    frame_.refine_available = report.refine_available;
    frame_.reserve = report.reserve_at_cut;
    frame_.lateness = report.lateness;
    if (wall_clock_) {
      frame_.times = {report.cause,       report.release_delay,      report.host_actual,       report.times,
                      report.longest_job, report.longest_job_a.slot, report.longest_job_b.slot};
    }
    return writer_->frame(frame_, SteadyClock::now());
  };
}

Status RunRecord::finish(bool stopped) { return writer_ ? writer_->finish(stopped) : Status(Done{}); }

}  // namespace poise::app
