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
  }
  return "frame";
}

namespace simulation {

void trace_frame(std::span<const WorkerTally> tallies, const FrameReport& report, Trace& trace) {
  const StageTimes& times = report.times;
  const auto add = [&](TraceStage stage, SteadyClock::time_point begin, Nanoseconds length) {
    trace.add({begin, begin + length, report.frame, 0, 0, stage});
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
  for (std::size_t w = 0; w < tallies.size(); ++w) {
    const WorkerTally& tally = tallies[w];
    if (tally.begun == SteadyClock::time_point{} || tally.ended < tally.begun) continue;
    trace.add({tally.begun, tally.ended, report.frame, static_cast<std::uint32_t>(tally.jobs),
               static_cast<std::int16_t>(w), TraceStage::Worker});
  }
}

}  // namespace simulation
}  // namespace poise
