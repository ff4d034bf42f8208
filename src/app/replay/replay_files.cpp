// SPDX-License-Identifier: MIT
#include "app/replay/replay_files.h"

#include <fmt/format.h>

#include <utility>

#include "app/files/output_files.h"
#include "app/picture/drawn_frame.h"
#include "app/picture/picture.h"
#include "app/process/refusal.h"
#include "capture/observe.h"
#include "frame/stage_list.h"
#include "scene/run/policy_name.h"
#include "world/contact_model_names.h"

namespace poise::app {
namespace {

/// As in a capture of the run itself: times and causes are the record's, and so are threads, machine and build. With
/// counted work a record has no times; then all of these are the replay's.
capture::CaptureHeader replay_header(const io::RecordHeader& record, const Scene& scene, const SceneRun& run) {
  capture::CaptureHeader header = capture::header_of(scene, run);
  header.dt_s = record.dt_s;
  if (record.clock == "wall") {
    header.deadline_ms = record.deadline_ms;
    header.threads = record.world.threads;
    header.machine = record.machine;
    header.build = record.build;
  }
  header.paced = record.paced;
  header.frames_asked = record.frames;
  header.policy = io::policy_name(record.world.policy.kind);
  for (const simulation::NamedContactModel& named : simulation::kContactModels) {
    if (named.model == record.world.contact) header.contact = named.name;
  }
  return header;
}

FrameReport as_recorded(FrameReport report, const io::RecordedFrame& recorded) {
  report.budget = recorded.budget;
  report.reserve_at_cut = recorded.reserve;
  report.lateness = recorded.lateness;
  if (recorded.times) {
    report.times = recorded.times->stages;
    report.times.total = Nanoseconds(0);
    for (const simulation::StageMember& stage : simulation::kStages) report.times.total += report.times.*stage.time;
    report.host_actual = recorded.times->host;
    report.cause = recorded.times->cause;
  }
  return report;
}

}  // namespace

ReplayFiles::ReplayFiles(const ReplayOptions& options, RunCapture capture, ReportFiles report)
    : options_(options),
      frames_(replayed_frames(options).value()),
      capture_(std::move(capture)),
      report_(std::move(report)) {}

Result<ReplayFiles> ReplayFiles::open(const ReplayOptions& given) {
  ReplayOptions options = given;
  if (!options.report.empty() && options.capture.file.empty()) options.capture.file = report_capture_of(options.report);
  // First, since it makes the folder in which the capture may lie.
  Result<ReportFiles> report = ReportFiles::open(options.report);
  Status all = report ? Status(Done{}) : Status(report.error());
  Result<RunCapture> capture = RunCapture::open(options.capture);
  if (!capture) add_failure(capture.error(), all);
  Result<FilmFrames> film = FilmFrames::open(options.picture);
  if (!film) add_failure(film.error(), all);
  std::optional<io::AtomicFile> picture = open_file(options.picture.file, all);
  if (!all) return all.error();
  ReplayFiles made(options, std::move(capture).value(), std::move(report).value());
  made.film_ = std::move(film).value();
  made.picture_ = std::move(picture);
  return made;
}

Status ReplayFiles::begin(const io::RecordHeader& record, const Scene& scene, SceneRun& run) {
  record_ = &record;
  scene_ = &scene;
  run_ = &run;
  if (options_.picture.any())
    pictures_.emplace(capture::captured_shapes(scene, run), picture_settings(options_.picture));
  if (capture_.on() && frames_.from == 0) return begin_capture({});
  capture_.watch(scene, run);
  return Done{};
}

Status ReplayFiles::begin_capture(const std::optional<capture::FrameFacts>& first) {
  return capture_.begin(*scene_, *run_, replay_header(*record_, *scene_, *run_), RunCapture::WhenFull::Wait, first);
}

ReplayCapture ReplayFiles::capture_sink() {
  if (!capture_.on()) return {};
  return [this](const FrameReport& report, const io::RecordedFrame& recorded) { return captured(report, recorded); };
}

Status ReplayFiles::captured(const FrameReport& report, const io::RecordedFrame& recorded) {
  const FrameReport seen = as_recorded(report, recorded);
  capture::FrameFacts facts = capture::facts_of(seen, run_->view(), record_->dt_s);
  facts.kinetic_j = report.kinetic_j;
  facts.potential_j = report.potential_j;
  facts.momentum_ns = capture::captured_momentum(report.momentum_ns);
  if (facts.frame < frames_.from) {
    capture_.pass();
    return Done{};
  }
  if (!options_.report.empty()) {
    simulation::RunFrame frame;
    frame.report = seen;
    charted_.push_back(frame);
  }
  return capture_.begun() ? capture_.frame(facts) : begin_capture(facts);
}

ReplayPicture ReplayFiles::picture_sink() {
  if (!film_.on()) return {};
  return [this](std::uint64_t frame) { return drawn(frame); };
}

Status ReplayFiles::drawn(std::uint64_t frame) {
  if (frame < frames_.from || (frame - frames_.from) % options_.frames_every.value_or(1) != 0) return Done{};
  const Result<io::DrawnFrame> seen =
      io::drawn_frame(*scene_, *run_, frame, static_cast<double>(frame) * record_->dt_s);
  if (!seen) return seen.error();
  film_written_ = film_.write(frame, pictures_->draw(seen.value()));
  return film_written_;
}

Status ReplayFiles::finish(const ReplayResult& result) {
  const bool makes = capture_.on() || pictures_;
  if (makes && !result.stopped && !result.differs && result.frames < frames_.from)
    return bad_input(fmt::format("--frames {}: the record ends with frame {}", options_.frames, result.frames));
  if (options_.frame && !result.stopped && !result.differs && result.frames < *options_.frame)
    return bad_input(fmt::format("--frame {}: the record ends with frame {}", *options_.frame, result.frames));
  Status written = film_written_;
  const Status captured = capture_.begun() ? capture_.finish(result.stopped || result.run_stopped) : Status(Done{});
  add_failure(captured, written);
  if (captured && capture_.begun()) {
    const std::optional<double> deadline_ms =
        record_->clock == "wall" ? std::optional(record_->deadline_ms) : std::nullopt;
    add_failure(report_.write("replay", {command_line(), {}, {}, {}}, options_.capture.file,
                              {scene_->name, deadline_ms, charted_}),
                written);
  }
  if (!picture_) return written;
  const Result<io::DrawnFrame> seen =
      io::drawn_frame(*scene_, *run_, result.frames, static_cast<double>(result.frames) * record_->dt_s);
  const Result<std::string> png =
      seen ? io::png_bytes(pictures_->draw(seen.value())) : Result<std::string>(seen.error());
  if (!png) {
    add_failure(png.error(), written);
    return written;
  }
  const Status drawn = picture_->write(png.value());
  add_failure(drawn ? picture_->commit() : drawn, written);
  return written;
}

std::string ReplayFiles::told() const {
  std::string text;
  if (film_.on()) text += fmt::format("{} pictures in {}\n", film_.written(), options_.picture.frames_dir);
  if (options_.report.empty()) return text;
  text += report_page_of(options_.report);
  text += record_->clock == "wall"
              ? ": its times are those of the recorded run\n"
              : ": its times are those of this replay, since a record with counted work has none\n";
  return text;
}

}  // namespace poise::app
