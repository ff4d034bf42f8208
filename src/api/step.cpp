// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "dynamics/conserved.h"
#include "frame/budget/cpu_clock.h"
#include "frame/budget/degrade.h"
#include "frame/budget/frame_time.h"
#include "frame/report/levels_reached.h"
#include "frame/report/trace.h"
#include "frame/sleeping.h"
#include "frame/stages.h"
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

StepStatus check(const StepInput& input, std::uint64_t frame) {
  if (!(input.dt_s > 0 && input.dt_s <= kMaxTimeStepS)) return StepStatus::RefusedTimeStep;
  if (!sound(input.view)) return StepStatus::RefusedView;
  if (input.host_work.expected.count() < 0) return StepStatus::RefusedHostWork;
  if (input.replay != nullptr && input.replay->frame != frame) return StepStatus::RefusedReplay;
  return StepStatus::Done;
}

// Pairs of bodies that were removed since the last step start anew, also where their slots are used again; what touched
// ends.
void forget_removed(simulation::WorldState& world) {
  std::vector<BodyId>& removed = world.removed_bodies;
  if (removed.empty()) return;
  std::sort(removed.begin(), removed.end());
  // Of a slot that was used twice, the body of the last step: the oldest one.
  const auto body_of = [&](std::uint32_t slot) {
    const auto at = std::lower_bound(removed.begin(), removed.end(), BodyId{slot, 0});
    return at != removed.end() && at->slot == slot ? *at : world.bodies.id_of(slot);
  };
  const auto is_removed = [&](std::uint32_t slot) {
    const auto at = std::lower_bound(removed.begin(), removed.end(), BodyId{slot, 0});
    return at != removed.end() && at->slot == slot;
  };
  std::erase_if(world.memory, [&](const simulation::CachedPair& pair) {
    const bool gone = is_removed(pair.low) || is_removed(pair.high);
    if (!gone) return false;
    world.points.give_back(pair.room);
    if (pair.touching) world.removal_events.push_back({ContactEvent::Kind::End, body_of(pair.low), body_of(pair.high)});
    return true;
  });
  removed.clear();
}

// What is kept of a body that the caller has put somewhere else no longer holds.
void forget_displaced(simulation::WorldState& world) {
  if (world.displaced_slots.empty()) return;
  std::sort(world.displaced_slots.begin(), world.displaced_slots.end());
  const auto displaced = [&](std::uint32_t slot) {
    return std::binary_search(world.displaced_slots.begin(), world.displaced_slots.end(), slot);
  };
  for (simulation::CachedPair& pair : world.memory) {
    if (!displaced(pair.low) && !displaced(pair.high)) continue;
    pair.reach_m = 0;
    pair.apart = false;
  }
  world.displaced_slots.clear();
}

// The pairs of the frame. What sleeps and has a moving body near it wakes, so that none is met as if it were static.
void find_awake_pairs(simulation::WorldState& world, const StepInput& input, FrameReport& report) {
  simulation::find_pairs(world, input, report);
  if (!world.settings.sleeping) return;
  while (simulation::wake_touched(world)) {
    const FrameReport before = report;
    simulation::predict(world, input);
    simulation::find_pairs(world, input, report);
    report.times.broad_phase += before.times.broad_phase;
    report.times.coarse += before.times.coarse;
    report.work_mandatory += before.work_mandatory;
  }
}

// A stopwatch for stages that follow each other.
class Laps {
 public:
  explicit Laps(SteadyClock::time_point start) : last_(start) {}
  Nanoseconds lap() {
    const SteadyClock::time_point now = SteadyClock::now();
    const Nanoseconds passed = now - last_;
    last_ = now;
    return passed;
  }
  /// When the last stage ended.
  [[nodiscard]] SteadyClock::time_point at() const { return last_; }

 private:
  SteadyClock::time_point last_;
};

// One checked step, timed.
FrameReport run_frame(simulation::WorldState& world, const StepInput& input) {
  const SteadyClock::time_point start = SteadyClock::now();
  FrameReport report;
  const Nanoseconds cpu_before = simulation::thread_cpu_time();
  world.executor->wake();
  report.frame = world.frame;
  report.started = start;
  report.bodies = world.bodies.dynamic_count() + world.bodies.asleep_count();

  simulation::begin_frame_time(world, input, start, report);
  Laps laps(start);
  if (world.settings.sleeping) simulation::wake_near_changes(world);
  forget_removed(world);
  forget_displaced(world);
  simulation::predict(world, input);
  report.times.predict = laps.lap();
  find_awake_pairs(world, input, report);
  laps.lap();
  report.refine_started = laps.at();
  simulation::refine(world, input, report);
  report.times.refine = laps.lap();
  simulation::respond(world, input, report);
  report.times.response = laps.lap();
  simulation::integrate(world, input);
  report.times.integrate = laps.lap();
  simulation::publish(world, input);
  simulation::restore(world);
  ++world.frame;
  // A reference must find the bodies that the frame had.
  if (world.settings.sleeping && !input.reference) simulation::fall_asleep(world, input.dt_s, report);
  report.times.publish = laps.lap();
  simulation::account_time(world, input, start, cpu_before, report);
  return report;
}

// The same with what a reference must keep before it, in no time of the frame.
FrameReport run_and_refer(simulation::WorldState& world, const StepInput& input) {
  const SteadyClock::time_point begun = SteadyClock::now();
  simulation::remember(world);
  StepInput moved = input;
  const Nanoseconds cached = SteadyClock::now() - begun;
  if (moved.budget.deadline < SteadyClock::time_point::max() - cached) moved.budget.deadline += cached;
  FrameReport report = run_frame(world, moved);
  world.settle();
  report.reference = simulation::refer(world, input);
  report.reference->time += cached;
  if (world.settings.sleeping) simulation::fall_asleep(world, input.dt_s, report);
  return report;
}

}  // namespace

FrameReport World::step(const StepInput& given) {
  StepInput input = given;
  // Nothing of a step that is done again is up to a clock.
  if (input.replay != nullptr) input.budget = Budget::unlimited();
  const StepStatus status = check(input, state_->frame);
  if (status != StepStatus::Done) {
    FrameReport refused;
    refused.status = status;
    return refused;
  }
  if (input.budget.kind == Budget::Kind::Deadline)
    input.budget.deadline = within_reach(input.budget.deadline, SteadyClock::now());
  input.host_work.expected = std::min(input.host_work.expected, kFarthestTime);
  state_->settle();
  ++state_->changes;
  if (state_->decisions && (!input.record || input.replay != nullptr)) state_->decisions->forget();
  FrameReport report = input.reference ? run_and_refer(*state_, input) : run_frame(*state_, input);
  if (input.trace != nullptr) simulation::trace_frame(*state_, report, *input.trace);
  if (input.measure_levels) report.levels = simulation::levels_reached(*state_, input.view);
  if (input.measure_energy) {
    const Conserved sums = dynamics::conserved_sums(state_->bodies, state_->settings.gravity_mps2);
    report.kinetic_j = sums.kinetic_j;
    report.potential_j = sums.potential_j;
  }
  return report;
}

}  // namespace poise
