// SPDX-License-Identifier: MIT
#include <algorithm>

#include "frame/stage_list.h"
#include "scene/run/run_report.h"

namespace poise::simulation {
namespace {

WorstFrame worst_frame(const RunFrame& frame) {
  const FrameReport& report = frame.report;
  WorstFrame worst;
  worst.frame = report.frame;
  worst.lateness = report.lateness;
  worst.cause = report.cause;
  worst.release_delay = report.release_delay;
  worst.stage = "host";
  worst.stage_time = report.host_actual;
  for (const StageMember& stage : kStages) {
    if (report.times.*stage.time < worst.stage_time) continue;
    worst.stage = stage.name;
    worst.stage_time = report.times.*stage.time;
  }
  if (report.cause == MissCause::Overrun && report.longest_job.count() > 0) {
    worst.piece = {report.frame, frame.longest_job_bodies[0], frame.longest_job_bodies[1]};
    worst.piece_time = report.longest_job;
  }
  return worst;
}

}  // namespace

std::vector<WorstFrame> worst_frames(std::span<const RunFrame> frames) {
  std::vector<WorstFrame> worst;
  for (const RunFrame& frame : frames) {
    if (frame.report.lateness.count() > 0) worst.push_back(worst_frame(frame));
  }
  std::stable_sort(worst.begin(), worst.end(),
                   [](const WorstFrame& a, const WorstFrame& b) { return a.lateness > b.lateness; });
  worst.resize(std::min(worst.size(), kWorstFrames));
  return worst;
}

MissCause cause_of_release(MissCause before, bool waited) {
  if (waited) return MissCause::Machine;
  return before == MissCause::None ? MissCause::Release : before;
}

const char* cause_name(MissCause cause) {
  switch (cause) {
    case MissCause::None:
      return "none";
    case MissCause::Release:
      return "release";
    case MissCause::Infeasible:
      return "infeasible";
    case MissCause::Machine:
      return "machine";
    case MissCause::Overrun:
      return "overrun";
    case MissCause::Forecast:
      return "forecast";
  }
  return "none";
}

const char* cause_text(MissCause cause) {
  switch (cause) {
    case MissCause::None:
      return "it was in time";
    case MissCause::Release:
      return "it began too late, after a frame that was in time";
    case MissCause::Infeasible:
      return "what every frame must do took longer than the deadline";
    case MissCause::Machine:
      return "the system kept the processor for at least as long as the frame was late, or woke it late";
    case MissCause::Overrun:
      return "one piece of refinement took longer than a piece may";
    case MissCause::Forecast:
      return "the end of the frame took longer than was kept for it";
  }
  return "it was in time";
}

}  // namespace poise::simulation
