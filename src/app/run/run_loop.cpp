// SPDX-License-Identifier: MIT
#include "app/run/run_loop.h"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <string>

#include "frame/budget/frame_time.h"
#include "scene/run/reference_turns.h"
#include "scene/run/release_grid.h"

namespace poise::app {
namespace {

/// One frame in so many tells how deep bodies got: listing contacts takes time between frames. Chosen.
constexpr std::uint64_t kLookAtLevels = 16;

/// steady_clock is CLOCK_MONOTONIC here, so its time points can be slept until without drift. Ends early when
/// the run is stopped.
void sleep_until(SteadyClock::time_point when, const parallel::Interrupt& interrupt) {
  const auto since = std::chrono::duration_cast<Nanoseconds>(when.time_since_epoch()).count();
  constexpr std::int64_t kSecond = 1'000'000'000;
  const timespec target{static_cast<time_t>(since / kSecond), static_cast<long>(since % kSecond)};
  while (!interrupt.asked() && ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &target, nullptr) == EINTR) {
  }
}

Status tell_states(const SceneRun& run, std::uint64_t frame, std::vector<io::NumberedState>& buffer,
                   const StatesSink& sink) {
  if (!sink) return Done{};
  const Status read = io::read_states(run, buffer);
  return read ? sink(frame, buffer) : read;
}

std::uint64_t number_of(const SceneRun& run, BodyId id) {
  const std::span<const RunBody> bodies = run.bodies();
  const auto found = std::find_if(bodies.begin(), bodies.end(), [id](const RunBody& body) { return body.id == id; });
  return found == bodies.end() ? 0 : found->number;
}

/// Names the bodies of the pieces that a step has traced while all of them are there.
class TracedPairs {
 public:
  void note(const SceneRun& run, const Trace& trace, std::vector<std::array<std::uint64_t, 2>>& pairs) {
    const std::span<const TraceSpan> spans = std::span(trace.spans()).subspan(seen_);
    seen_ += spans.size();
    if (std::ranges::find(spans, TraceStage::Piece, &TraceSpan::stage) == spans.end()) return;
    numbers_.clear();
    for (const RunBody& body : run.bodies()) {
      if (body.id.slot >= numbers_.size()) numbers_.resize(body.id.slot + std::size_t{1});
      numbers_[body.id.slot] = body.number;
    }
    const auto number = [&](BodyId id) { return id.slot < numbers_.size() ? numbers_[id.slot] : 0; };
    for (const TraceSpan& span : spans) {
      if (span.stage == TraceStage::Piece) pairs.push_back({number(span.body_a), number(span.body_b)});
    }
  }

 private:
  std::size_t seen_ = 0;                // spans
  std::vector<std::uint64_t> numbers_;  // by slot
};

/// Names the bodies that a report may name. `longest_job` is that of the measured frames so far.
void name_bodies(const SceneRun& run, Nanoseconds& longest_job, simulation::RunFrame& frame) {
  const FrameReport& report = frame.report;
  const bool longest = !frame.warm_up && report.longest_job > longest_job;
  if (longest) longest_job = report.longest_job;
  if (longest || report.cause == MissCause::Overrun)
    frame.longest_job_bodies = {number_of(run, report.longest_job_a), number_of(run, report.longest_job_b)};
  if (report.out_of_range > 0) frame.out_of_range_body = number_of(run, report.out_of_range_body);
}

StepInput step_input(const LoopSettings& settings) {
  StepInput input;
  input.dt_s = settings.dt_s;
  input.host_work.expected = settings.host_work;
  input.host_work.learn = settings.learn_host_work;
  input.max_level = settings.max_level;
  input.polygons = settings.polygons;
  input.backtracking = settings.backtracking;
  input.measure_energy = true;
  input.trace = settings.trace;
  if (!settings.wall_clock && settings.budget_work) input.budget = Budget::work(*settings.budget_work);
  return input;
}

}  // namespace

Status check_memory_of_frames(const LoopSettings& settings, const std::optional<std::uint64_t>& most_bytes) {
  const std::uint64_t frames = settings.warm_up + settings.frames;
  if (!most_bytes || frames <= *most_bytes / sizeof(simulation::RunFrame)) return Done{};
  return bad_input(fmt::format(
      "{} frames: their figures take {} MiB, {} bytes a frame, and --max-memory, or what the machine has, is {} MiB",
      frames, (frames * sizeof(simulation::RunFrame)) >> 20U, sizeof(simulation::RunFrame), *most_bytes >> 20U));
}

Result<LoopResult> run_loop(SceneRun& run, const LoopSettings& settings, const parallel::Interrupt& interrupt,
                            const StatesSink& states, const FrameSink& told, const RecordSink& record,
                            const CaptureSink& capture) {
  LoopResult result;
  std::vector<io::NumberedState> buffer;
  result.start = run.world().conserved();
  result.energy_max_j = result.start.kinetic_j + result.start.potential_j;
  Status status = tell_states(run, 0, buffer, states);
  if (!status) return status.error();
  StepInput input = step_input(settings);
  Nanoseconds longest_job{0};
  TracedPairs traced;
  input.record = static_cast<bool>(record);
  simulation::ReferenceTurns references(settings.reference_every);
  const bool slices = settings.wall_clock && run.world().settings().islands_wait == IslandsWait::Any;
  const std::uint64_t total = settings.warm_up + settings.frames;
  result.frames.reserve(total);
  simulation::ReleaseGrid grid(SteadyClock::now(), settings.dt_s, settings.deadline);
  for (std::uint64_t i = 0; i < total && (i == 0 || !interrupt.asked()); ++i) {
    status = run.before_frame(i);
    if (!status) return status.error();
    input.view = run.view();
    bool waited = false;
    if (settings.paced) {
      waited = SteadyClock::now() < grid.release();
      sleep_until(grid.release(), interrupt);
      if (i > 0 && interrupt.asked()) break;
    }
    const SteadyClock::time_point begin = SteadyClock::now();
    if (settings.wall_clock) input.budget = Budget::until(settings.paced ? grid.deadline() : begin + settings.deadline);
    if (settings.paced) input.release = grid.release();
    simulation::RunFrame frame;
    frame.warm_up = i < settings.warm_up;
    input.reference = !frame.warm_up && references.due(i - settings.warm_up + 1, !run.world().step_unfinished());
    input.may_slice = slices && !input.reference;
    input.measure_levels = i % kLookAtLevels == kLookAtLevels - 1;
    frame.report = run.world().step(input);
    if (frame.report.status != StepStatus::Done) return bad_input("the step was refused: its input is out of range");
    simulation::LoadTime load;
    if (settings.render_load.any()) {
      load = simulation::burn(simulation::load_of(settings.render_load, i));
      run.world().report_host_work(load.wall);
      simulation::add_host_work(load.wall, load.off_cpu, frame.report);
    }
    if (frame.report.cause == MissCause::Release) {
      const MissCause before = result.frames.empty() ? MissCause::None : result.frames.back().report.cause;
      frame.report.cause = simulation::cause_of_release(before, waited);
    }
    name_bodies(run, longest_job, frame);
    const SteadyClock::time_point recorded_from = SteadyClock::now();
    if (settings.trace != nullptr) traced.note(run, *settings.trace, result.traced_pairs);
    status = record ? record(frame.report) : Status(Done{});
    if (status && capture) status = capture(frame);
    if (status && (i + 1) % settings.states_every == 0) status = tell_states(run, i + 1, buffer, states);
    if (!status) return status.error();
    const Nanoseconds recorded =
        record || capture || states || settings.trace != nullptr ? SteadyClock::now() - recorded_from : Nanoseconds(0);
    if (settings.paced) {
      if (input.measure_levels) {
        grid.postpone(SteadyClock::now() - (frame.report.started + frame.report.times.total + load.wall));
      } else {
        grid.postpone(recorded);
        if (frame.report.reference) grid.postpone(frame.report.reference->time);
      }
      frame.releases_skipped = grid.advance(SteadyClock::now());
      // Releases that pass after the last frame were never to be served.
      if (i + 1 == total) frame.releases_skipped = 0;
    }
    if (!frame.warm_up)
      result.energy_max_j = std::max(result.energy_max_j, frame.report.kinetic_j + frame.report.potential_j);
    result.frames.push_back(frame);
    if (told) told(frame);
  }
  result.end = run.world().conserved();
  result.stopped = interrupt.asked();
  return result;
}

}  // namespace poise::app
