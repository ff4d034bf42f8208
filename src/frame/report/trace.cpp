// SPDX-License-Identifier: MIT
#include "frame/report/trace.h"

#include "poise/trace.h"

namespace poise {

const char* trace_name(TraceStage stage) {
  switch (stage) {
    case TraceStage::Frame:
      return "frame";
    case TraceStage::Predict:
      return "predict";
    case TraceStage::BroadPhase:
      return "broad_phase";
    case TraceStage::Coarse:
      return "coarse";
    case TraceStage::Refine:
      return "refine";
    case TraceStage::Manifolds:
      return "manifolds";
    case TraceStage::Solve:
      return "solve";
    case TraceStage::Integrate:
      return "integrate";
    case TraceStage::Publish:
      return "publish";
    case TraceStage::Worker:
      return "jobs";
    case TraceStage::Piece:
      return "piece";
  }
  return "frame";
}

namespace simulation {

void trace_stages(const FrameReport& report, Trace& trace) {
  const StageTimes& times = report.times;
  const auto add = [&](TraceStage stage, SteadyClock::time_point begin, Nanoseconds length) {
    trace.add({begin, begin + length, report.frame, 0, 0, {}, {}, 0, stage});
    return begin + length;
  };
  add(TraceStage::Frame, report.started, times.total);
  SteadyClock::time_point at = add(TraceStage::Predict, report.started, times.predict);
  at = add(TraceStage::BroadPhase, at, times.broad_phase);
  at = add(TraceStage::Coarse, at, times.coarse);
  at = add(TraceStage::Refine, at, times.refine);
  at = add(TraceStage::Manifolds, at, times.manifolds);
  at = add(TraceStage::Solve, at, times.solve);
  at = add(TraceStage::Integrate, at, times.integrate);
  add(TraceStage::Publish, at, times.publish);
}

void trace_frame(const Frame& frame, const dynamics::BodyStore& bodies, const FrameReport& report, Trace& trace) {
  trace_stages(report, trace);
  const std::vector<WorkerTally>& tallies = frame.levels.tallies;
  for (std::size_t w = 0; w < tallies.size(); ++w) {
    const WorkerTally& tally = tallies[w];
    if (tally.begun == SteadyClock::time_point{} || tally.ended < tally.begun) continue;
    TraceSpan jobs;
    jobs.begin = tally.begun;
    jobs.end = tally.ended;
    jobs.frame = report.frame;
    jobs.lane = static_cast<std::int16_t>(w);
    jobs.stage = TraceStage::Worker;
    jobs.jobs = static_cast<std::uint32_t>(tally.jobs);
    trace.add(jobs);
    if (tally.longest <= Nanoseconds(0)) continue;
    const ActivePair& pair = frame.table.pairs[tally.longest_pair];
    TraceSpan piece = jobs;
    piece.begin = tally.longest_begun;
    piece.end = tally.longest_ended;
    piece.jobs = 0;
    piece.stage = TraceStage::Piece;
    piece.units = tally.longest_units;
    piece.body_a = bodies.id_of(pair.low());
    piece.body_b = bodies.id_of(pair.high());
    trace.add(piece);
  }
}

}  // namespace simulation
}  // namespace poise
