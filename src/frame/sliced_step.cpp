// SPDX-License-Identifier: MIT
#include "frame/sliced_step.h"

#include <algorithm>

#include "frame/budget/frame_time.h"
#include "frame/budget/islands.h"
#include "frame/run_frame.h"
#include "frame/stage_list.h"
#include "parallel/ranges.h"

namespace poise::simulation {
namespace {

// Bodies of which a column is copied at once.
constexpr std::size_t kHiddenGrain = 2048;
// A step is done at once again if what must be done, and its share of refinement, take so much of a frame at most.
constexpr double kAmple = 0.75;
// The most time that a step has: as many frames as bodies in view may wait for, or so many times what must be done.
// That is enough to refine all pairs of a heap that lands (2 to 3 times). Chosen.
constexpr double kFrames = static_cast<double>(kMostTurns), kLeastFrameNs = 1e6;
constexpr double kOfMandatory = 4;

bool may_slice(const WorldState& world, const StepInput& input) {
  return input.may_slice && input.budget.kind == Budget::Kind::Deadline && !input.backtracking && !input.reference &&
         world.settings.contact != ContactModel::Paper;
}

// Did bodies wait that could have been looked at?
bool bodies_waited(const WorldState& world) { return world.outputs.levels.held.bodies > 0; }

double ns_of(Nanoseconds time) { return static_cast<double>(time.count()); }

Nanoseconds mandatory(const WorldState& world, const StepInput& input) {
  return mandatory_forecast(input, world.bodies.dynamic_count(), world.settings.substeps, world.forecasts);
}

// The step, on the thread of its task.
void run_step(WorldState& world, SlicedStep& sliced) {
  StepInput input = sliced.input;
  const double whole_ns =
      std::max(kFrames * std::max(ns_of(sliced.slice), kLeastFrameNs), kOfMandatory * ns_of(mandatory(world, input)));
  input.budget = Budget::until(sliced.task.executor().time() + Nanoseconds(static_cast<std::int64_t>(whole_ns)));
  // Each slice leaves the host its time.
  input.host_work = {};
  input.release.reset();
  input.trace = nullptr;
  sliced.begun = sliced.task.executor().time();
  sliced.told = {};
  sliced.report = run_frame(world, input, true, &sliced);
  sliced.stages = nullptr;
  sliced.mandatory = sliced.report.mandatory;
  sliced.refinement_ns =
      world.forecasts.pair_cost.by_score_ns * static_cast<double>(world.outputs.levels.known.refinable);
}

void exchange(WorldState& world, SlicedStep& sliced) {
  world.bodies.exchange(sliced.states);
  world.events.events.swap(sliced.events);
}

// Returns whether the step has ended.
bool go_on(WorldState& world, SlicedStep& sliced, SteadyClock::time_point until) {
  if (sliced.moving) exchange(world, sliced);
  const bool ended = sliced.task.run_until(until, world.settings.alpha);
  if (ended) {
    sliced.moving = false;
  } else if (sliced.moving) {
    exchange(world, sliced);
  }
  return ended;
}

// Would the last step have fitted into a frame, with a part of its refinement, had it had `share` of its bodies?
bool fits_at_once(const SlicedStep& sliced, double share, Nanoseconds left) {
  const double refined_ns =
      std::max(kRefinedInSlices * sliced.refinement_ns, ns_of(share_of_refinement(sliced.refinement_ns, left)));
  return share * (ns_of(sliced.mandatory) + refined_ns) <= kAmple * ns_of(left);
}

// Of the bodies of the last step those that take part now: the others have been paused since.
double share_of_last(const WorldState& world) {
  const TimeFacts& last = world.forecasts.times;
  const auto then = static_cast<double>(last.load - last.active_pairs);
  return then > 0 ? std::min(1.0, static_cast<double>(world.bodies.dynamic_count()) / then) : 1.0;
}

bool begin(WorldState& world, const StepInput& input, SlicedStep& sliced) {
  if (!sliced.task.begin([&world, &sliced] { run_step(world, sliced); })) return false;
  sliced.input = input;
  sliced.sums.reset();
  if (input.record && !world.decisions) world.decisions = std::make_unique<DecisionLog>();
  return true;
}

// The times of the stages in this frame: of the one that goes on, so far.
StageTimes stages_of_frame(SlicedStep& sliced, bool ended) {
  StageTimes all = ended ? sliced.report.times : StageTimes{};
  if (!ended && sliced.stages != nullptr) {
    all = *sliced.stages;
    Nanoseconds left = sliced.task.executor().time() - sliced.begun;
    for (const StageMember& stage : kStages) left -= all.*stage.time;
    // The stages follow each other, and none takes no time.
    const auto* const next =
        std::ranges::find_if(kStages, [&](const StageMember& stage) { return all.*stage.time == Nanoseconds(0); });
    if (next != kStages.end()) all.*next->time += std::max(left, Nanoseconds(0));
  }
  StageTimes here;
  for (const StageMember& stage : kStages)
    here.*stage.time = std::max(all.*stage.time - sliced.told.*stage.time, Nanoseconds(0));
  sliced.told = all;
  return here;
}

void note_unfinished(WorldState& world, FrameReport& report) {
  report.unfinished = true;
  report.asleep = world.bodies.asleep_count() - world.bodies.paused_count();
  report.degraded.bodies_paused = world.bodies.paused_count();
  report.degraded.bodies_held = world.bodies.dynamic_count() + report.degraded.bodies_paused;
  // Nothing began or ended in it.
  world.events.events.clear();
  ++world.frame;
  ++world.frames_unfinished;
  ++world.frames_without_step;
}

}  // namespace

bool wants_slices(const WorldState& world, const StepInput& input) {
  if (!may_slice(world, input)) return false;
  const Nanoseconds left = time_of_step(input, SteadyClock::now(), world.forecasts);
  const double share = share_of_last(world);
  if (world.sliced && world.sliced->last) return !fits_at_once(*world.sliced, share, left);
  // Of a World that has not stepped yet nothing is known. Islands that take turns do so from frame to frame.
  return world.forecasts.times.frames == 0 || share * ns_of(mandatory(world, input)) > ns_of(left) ||
         (bodies_waited(world) && world.bodies.paused_count() == 0);
}

FrameReport run_slice(WorldState& world, const StepInput& input) {
  const SteadyClock::time_point start = SteadyClock::now();
  if (!world.sliced) world.sliced = std::make_unique<SlicedStep>(*world.executor);
  SlicedStep& sliced = *world.sliced;
  const bool limited = input.budget.kind == Budget::Kind::Deadline;
  Nanoseconds time_left{0};
  if (limited) sliced.slice = time_left = time_of_step(input, start, world.forecasts);
  // A host that leaves it no time gets to its end too: from the frame on by which a step should have ended, late or
  // not.
  constexpr Nanoseconds kLeastSlice(static_cast<std::int64_t>(kLeastFrameNs));
  if (limited && world.frames_unfinished >= kMostTurns) sliced.slice = std::max(sliced.slice, kLeastSlice);
  if (!sliced.task.unfinished() && !begin(world, input, sliced)) return run_frame(world, input);
  sliced.frame = &input;
  sliced.slice_begun = start;
  const parallel::Waits waits_before = world.executor->waits();
  world.executor->wake();
  const bool ended = go_on(world, sliced, limited ? start + sliced.slice : SteadyClock::time_point::max());
  sliced.frame = nullptr;
  sliced.last = true;
  FrameReport report;
  if (ended) report = sliced.report;
  report.times = stages_of_frame(sliced, ended);
  report.frame = world.frame - (ended ? 1 : 0);
  report.started = start;
  report.bodies = world.bodies.dynamic_count() + world.bodies.asleep_count();
  report.infeasible_forecast = true;
  report.host_reserved = limited ? input.budget.deadline - (start + time_left) : Nanoseconds(0);
  if (input.release) report.release_delay = std::max(Nanoseconds(0), start - *input.release);
  if (!ended) note_unfinished(world, report);
  if (sliced.input.record && ended) world.decisions->finished(report.frame);
  if (sliced.input.record && !ended) world.decisions->unfinished(report.frame);
  report.times.total = SteadyClock::now() - start;
  account_slice(input, {sliced.task.slice_cpu(), world.executor->waits() - waits_before}, report);
  return report;
}

FrameReport replay_unfinished(WorldState& world, const StepInput& input) {
  if (!world.sliced) world.sliced = std::make_unique<SlicedStep>(*world.executor);
  if (world.frames_unfinished == 0) {
    world.sliced->input = input;
    world.sliced->sums.reset();
  }
  FrameReport report;
  report.started = SteadyClock::now();
  report.frame = world.frame;
  report.bodies = world.bodies.dynamic_count() + world.bodies.asleep_count();
  note_unfinished(world, report);
  return report;
}

FrameReport replay_slices(WorldState& world, const StepInput& input) {
  StepInput begun = world.sliced->input;
  begun.replay = input.replay;
  begun.explain = input.explain;
  return run_frame(world, begun);
}

void hide_end(WorldState& world, SlicedStep& sliced) {
  dynamics::BodyStates& states = sliced.states;
  const dynamics::BodyStore& bodies = world.bodies;
  parallel::Executor& executor = sliced.task.executor();
  const std::size_t slots = bodies.slot_count();
  const parallel::Ranges ranges(slots, kHiddenGrain);
  const auto copy = [&](const auto& from, auto& to) {
    // New memory is touched here for the first time. Afterwards there is none.
    to.reserve(slots);
    const std::size_t before = std::min(to.size(), slots);
    parallel::serial_for(executor, slots - before, kHiddenGrain,
                         [&](std::size_t, std::size_t end) { to.resize(before + end); });
    to.resize(slots);
    parallel::for_ranges(executor, ranges, [&](std::size_t, std::size_t begin, std::size_t end) {
      std::copy(from.begin() + static_cast<std::ptrdiff_t>(begin), from.begin() + static_cast<std::ptrdiff_t>(end),
                to.begin() + static_cast<std::ptrdiff_t>(begin));
    });
  };
  for (std::size_t k = 0; k < dynamics::BodyStates::kColumns; ++k)
    copy(bodies.*dynamics::BodyStore::kColumnsOfState[k], states.columns[k]);
  copy(bodies.dynamic, states.dynamic);
  copy(bodies.asleep, states.asleep);
  copy(bodies.paused, states.paused);
  states.dynamic_count = bodies.dynamic_count();
  states.asleep_count = bodies.asleep_count();
  states.paused_count = bodies.paused_count();
  world.events.events.swap(sliced.events);
  sliced.moving = true;
}

void end_sliced_step(WorldState& world) {
  if (!world.in_slices()) return;
  go_on(world, *world.sliced, SteadyClock::time_point::max());
  ++world.changes;
}

}  // namespace poise::simulation
