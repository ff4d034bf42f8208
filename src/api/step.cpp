// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <optional>

#include "frame/report/conserved_report.h"
#include "frame/report/levels_reached.h"
#include "frame/report/trace.h"
#include "frame/run_frame.h"
#include "frame/sliced_step.h"
#include "verify/reference.h"

namespace poise {
namespace {

bool sound(const View& view) {
  if (!view.present) return true;
  const auto unit = [](const Vec3& v) { return v.allFinite() && std::abs(v.norm() - 1.0) < 1e-6; };
  return view.position_m.allFinite() && unit(view.forward) && unit(view.up) && unit(view.gaze) &&
         std::abs(view.forward.dot(view.up)) < 1.0 - 1e-6 && view.vertical_fov_rad > 0 &&
         view.vertical_fov_rad < 3.14159 && std::isfinite(view.aspect) && view.aspect > 0;
}

bool sound(const Attention& attention) {
  return attention.center_m.allFinite() && std::isfinite(attention.radius_m) && attention.radius_m >= 0;
}

StepStatus check(const StepInput& input, std::uint64_t frame) {
  if (!(input.dt_s > 0 && input.dt_s <= kMaxTimeStepS)) return StepStatus::RefusedTimeStep;
  if (!sound(input.view) || !sound(input.attention)) return StepStatus::RefusedView;
  if (input.host_work.expected.count() < 0) return StepStatus::RefusedHostWork;
  if (input.replay != nullptr && input.replay->frame != frame) return StepStatus::RefusedReplay;
  return StepStatus::Done;
}

// A frame of a step in slices, or of its replay.
FrameReport run_part(simulation::WorldState& world, const StepInput& input) {
  if (input.replay == nullptr) return simulation::run_slice(world, input);
  return input.replay->unfinished ? simulation::replay_unfinished(world, input)
                                  : simulation::replay_slices(world, input);
}

// Is a frame to be a part of a step only?
bool is_part(const simulation::WorldState& world, const StepInput& input) {
  if (input.replay != nullptr) return input.replay->unfinished || world.frames_unfinished > 0;
  return world.in_slices() || simulation::wants_slices(world, input);
}

// A frame, and its reference: what that must remember before the frame is in no time of the frame.
FrameReport run_and_refer(simulation::WorldState& world, const StepInput& input) {
  const SteadyClock::time_point begun = SteadyClock::now();
  if (!world.reference) world.reference = std::make_unique<simulation::Reference>();
  simulation::remember(world, *world.reference);
  StepInput moved = input;
  const Nanoseconds copy_time = SteadyClock::now() - begun;
  if (moved.budget.deadline < SteadyClock::time_point::max() - copy_time) moved.budget.deadline += copy_time;
  if (moved.release) *moved.release += copy_time;
  // The reference must find the bodies that the frame had.
  FrameReport report = simulation::run_frame(world, moved, false);
  world.settle();
  report.reference = simulation::refer(world, input, world.pools, *world.reference);
  report.reference->time += copy_time;
  simulation::rest_after(world, input, report);
  return report;
}

void measure_energy(const simulation::WorldState& world, FrameReport& report) {
  Conserved sums;
  if (report.unfinished) {
    std::optional<Conserved>& kept = world.sliced->sums;
    if (!kept) kept = simulation::conserved(world);
    sums = *kept;
  } else {
    sums = simulation::conserved(world);
  }
  report.kinetic_j = sums.kinetic_j;
  report.potential_j = sums.potential_j;
  report.momentum_ns = sums.momentum_ns;
}

}  // namespace

FrameReport World::step(const StepInput& given) {
  StepInput input = given;
  // No clock decides anything in a replay.
  if (input.replay != nullptr) input.budget = Budget::unlimited();
  const StepStatus status = check(input, state_->frame);
  if (status != StepStatus::Done) {
    FrameReport refused;
    refused.status = status;
    return refused;
  }
  if (input.budget.kind == Budget::Kind::Deadline)
    input.budget.deadline = within_reach(input.budget.deadline, SteadyClock::now());
  if (input.release) input.release = within_reach(*input.release, SteadyClock::now());
  input.host_work.expected = std::min(input.host_work.expected, kFarthestTime);
  state_->settle();
  ++state_->changes;
  if (state_->decisions && (!input.record || input.replay != nullptr)) state_->decisions->forget();
  if (input.replay != nullptr) simulation::end_sliced_step(*state_);
  FrameReport report;
  if (is_part(*state_, input)) {
    report = run_part(*state_, input);
    if (input.trace != nullptr) simulation::trace_stages(report, *input.trace);
  } else {
    report = input.reference ? run_and_refer(*state_, input) : simulation::run_frame(*state_, input);
    if (state_->sliced) state_->sliced->last = false;
    if (input.trace != nullptr) simulation::trace_frame(state_->outputs, state_->bodies, report, *input.trace);
  }
  if (input.measure_levels && !report.unfinished) report.levels = simulation::levels_reached(*state_, input.view);
  if (input.measure_energy) measure_energy(*state_, report);
  return report;
}

}  // namespace poise
