// SPDX-License-Identifier: MIT
#include "app/replay/replay_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "parallel/executor.h"

namespace poise::app {
namespace {

StepInput step_input(const io::RecordHeader& header) {
  StepInput input;
  input.dt_s = header.dt_s;
  input.max_level = header.max_level;
  input.polygons = header.polygons;
  input.backtracking = header.backtracking;
  return input;
}

Status pass_states(const SceneRun& run, std::uint64_t frame, std::vector<io::NumberedState>& buffer,
                   const ReplayStates& states) {
  if (!states) return Done{};
  const Status read = io::read_states(run, buffer);
  return read ? states(frame, buffer) : read;
}

}  // namespace

WorldSettings replay_world(const io::RecordHeader& header, ExecutorKind executor, int threads) {
  constexpr std::uint64_t kMostEntries = 1U << 26U;
  WorldSettings world = header.world;
  world.executor = executor;
  world.threads = threads;
  const auto before = static_cast<std::uint64_t>(header.world.threads);
  const auto now = static_cast<std::uint64_t>(executor == ExecutorKind::Serial ? 1
                                              : threads > 0                    ? threads
                                                                               : parallel::available_threads());
  const std::uint64_t shared = (header.world.max_front_entries * before + now - 1) / now;
  world.max_front_entries =
      static_cast<std::uint32_t>(std::clamp<std::uint64_t>(shared, header.world.max_front_entries, kMostEntries));
  return world;
}

Result<ReplayResult> replay_loop(io::RecordReader& record, const Scene& scene, SceneRun& run,
                                 const ReplaySettings& settings, const ReplaySinks& sinks) {
  ReplayResult result;
  result.state_hash = run.world().state_hash();
  StepInput input = step_input(record.header());
  input.measure_energy = static_cast<bool>(sinks.capture);
  io::RecordedFrame recorded;
  FrameExplanation explanation;
  std::vector<io::NumberedState> buffer;
  Status status = pass_states(run, 0, buffer, sinks.states);
  if (status && sinks.picture) status = sinks.picture(0);
  if (!status) return status.error();
  const std::uint64_t most = settings.explain ? *settings.explain + 1 : settings.frames.value_or(UINT64_MAX);
  while (result.frames < most) {
    if (settings.stop.stop_requested()) {
      result.stopped = true;
      break;
    }
    const io::RecordReader::Next next = record.next(recorded);
    if (next == io::RecordReader::Next::Damaged) result.damage = record.damage();
    if (next == io::RecordReader::Next::End) {
      result.at_end = true;
      result.run_stopped = record.end().stopped;
    }
    if (next != io::RecordReader::Next::Frame) break;
    status = run.before_frame(result.frames);
    if (!status) return status.error();
    input.view = run.view();
    input.replay = &recorded.decisions;
    const bool explains = settings.explain == result.frames;
    input.explain =
        explains || result.frames + 1 >= settings.reasons_from.value_or(UINT64_MAX) ? &explanation : nullptr;
    const FrameReport report = run.world().step(input);
    if (report.status != StepStatus::Done && report.status != StepStatus::ReplayDiffers)
      return bad_input("the step was refused: its input is out of range");
    result.state_hash = run.world().state_hash();
    status = pass_states(run, result.frames + 1, buffer, sinks.states);
    if (status && sinks.capture) status = sinks.capture(report, recorded);
    if (status && sinks.picture) status = sinks.picture(result.frames + 1);
    if (!status) return status.error();
    if (explains) {
      // Of a frame whose step goes on nothing else is explained.
      if (report.unfinished) explanation.policy = record.header().world.policy;
      result.explained = io::ExplainedFrame{recorded, std::move(explanation), io::bodies_by_slot(scene, run),
                                            record.header().clock == "wall"};
    }
    if (result.state_hash != recorded.state_hash || report.status == StepStatus::ReplayDiffers) {
      result.differs = result.frames;
      result.recorded_hash = recorded.state_hash;
    }
    ++result.frames;
    if (sinks.progress) sinks.progress(result.frames, std::min(most, record.header().frames));
    if (result.differs) break;
  }
  return result;
}

}  // namespace poise::app
