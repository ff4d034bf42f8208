// SPDX-License-Identifier: MIT
#include <array>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "app/files/output_files.h"
#include "app/process/exit_codes.h"
#include "app/process/progress.h"
#include "app/process/refusal.h"
#include "frame/stage_list.h"
#include "parallel/counting_executor.h"
#include "parallel/interrupt.h"
#include "scene/run/percentiles.h"
#include "studies/study_timing.h"
#include "verify/world_access.h"

namespace poise::app {
namespace {

using parallel::CountedWork;
using simulation::kStages;

// What the bound for a machine with many cores is computed for.
constexpr int kCores = 16;

/// One figure of a stage over all frames of a state.
struct Counted {
  std::vector<double> work_ms, serial_ms, span_ms, on_cores_ms, loops;

  void add(const CountedWork& counted) {
    const auto ms = [](Nanoseconds time) { return static_cast<double>(time.count()) / 1e6; };
    work_ms.push_back(ms(counted.work));
    serial_ms.push_back(ms(counted.serial));
    span_ms.push_back(ms(counted.span));
    on_cores_ms.push_back(ms(counted.on_cores));
    loops.push_back(static_cast<double>(counted.loops));
  }
  [[nodiscard]] io::SpanRow row(bool settled, const char* stage) const {
    const auto median = [](const std::vector<double>& of) { return simulation::percentile(of, 0.5); };
    return {settled,       stage,         median(work_ms), median(serial_ms), median(span_ms), median(on_cores_ms),
            median(loops), work_ms.size()};
  }
};

/// The stages of one state, and their sum.
using CountedState = std::array<Counted, kStages.size() + 1>;

// The stages follow each other without a gap, so their times give the borders between them.
std::vector<CountedWork> count_stages(const parallel::CountingExecutor& executor, const FrameReport& report,
                                      const parallel::CountedAt& start, const parallel::CountedAt& end) {
  std::vector<SteadyClock::time_point> borders = {report.started};
  for (const simulation::StageMember& stage : kStages) borders.push_back(borders.back() + report.times.*stage.time);
  return count_stretches(executor.loops(), start, end, borders);
}

void add(const std::vector<CountedWork>& stages, CountedState& state) {
  CountedWork all;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    state[i].add(stages[i]);
    all.work += stages[i].work;
    all.serial += stages[i].serial;
    all.span += stages[i].span;
    all.on_cores += stages[i].on_cores;
    all.loops += stages[i].loops;
  }
  state.back().add(all);
}

}  // namespace

int study_span(const StudyTimingOptions& o) {
  const auto refuse_span = [](const Error& error) {
    return refuse("study scaling", exit_code_of(error), error.message);
  };
  const Status sound = check_timing_options(o);
  if (!sound) return refuse("study scaling", kExitBadUsage, sound.error().message);
  const Status writable = can_write({o.json, o.markdown});
  if (!writable) return refuse_span(writable.error());
  const parallel::Interrupt interrupt;
  io::SpanDocument document;
  document.scene = o.scene;
  document.bodies = o.bodies.empty() ? 20000 : o.bodies.front();
  document.cores = kCores;
  const std::uint64_t frames = o.frames.value_or(60);
  const std::uint64_t skip = o.skip.value_or(100);
  const std::uint64_t settle = std::max(o.settle.value_or(600), skip + frames);
  Result<SceneRun> run = timed_scene(o, document.bodies, 0);
  if (!run) return refuse_span(run.error());
  // Frames that are not counted run on all threads; the state is the same.
  auto counting = std::make_unique<parallel::CountingExecutor>(kCores);
  const parallel::CountingExecutor& counts = *counting;
  std::unique_ptr<parallel::Executor> other = std::move(counting);
  simulation::WorldState& world = simulation::WorldAccess::of(run.value().world());
  std::array<CountedState, 2> states;
  Progress progress(!o.quiet);
  for (std::uint64_t frame = 0; frame < settle + frames; ++frame) {
    if (interrupt.asked()) return refuse("study scaling", stopped_error());
    progress.share("counted frames", static_cast<double>(frame) / static_cast<double>(settle + frames));
    const Status ready = run.value().before_frame(frame);
    if (!ready) return refuse_span(ready.error());
    const bool falling = frame >= skip && frame < skip + frames;
    const bool counted = falling || frame >= settle;
    StepInput input;
    input.dt_s = 1.0 / 60;
    input.view = run.value().view();
    if (counted) {
      static_cast<parallel::CountingExecutor&>(*other).clear();
      std::swap(world.executor, other);
    }
    const parallel::CountedAt start = counts.now();
    const FrameReport report = run.value().world().step(input);
    const parallel::CountedAt end = counts.now();
    if (report.status != StepStatus::Done)
      return refuse("study scaling", kExitBadInput, "the step was refused: its input is out of range");
    if (!counted) continue;
    std::swap(world.executor, other);
    add(count_stages(counts, report, start, end), states[falling ? 0 : 1]);
  }
  progress.end();
  for (const bool settled : {false, true}) {
    const CountedState& state = states[settled ? 1 : 0];
    for (std::size_t i = 0; i < kStages.size(); ++i) document.rows.push_back(state[i].row(settled, kStages[i].name));
    document.rows.push_back(state.back().row(settled, "all of these"));
  }
  document.by = measured_by(o, 1);
  return write_timing(o, "scaling", io::span_json(document), io::span_markdown(document), io::span_charts(document));
}

}  // namespace poise::app
