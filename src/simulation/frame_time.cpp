// SPDX-License-Identifier: MIT
#include "simulation/frame_time.h"

#include <algorithm>
#include <cmath>

#include "simulation/cpu_clock.h"
#include "simulation/degrade.h"

namespace poise::simulation {
namespace {

constexpr double kUnknownUnitCostNs = 60;

// Where the margin begins when nothing is known: half as much again at 1 %, twice as much at 0.1 %. Chosen.
double first_log_quantile(double alpha) { return 0.4 + 0.3 * std::clamp(std::log10(0.01 / alpha), -1.0, 3.0); }

Nanoseconds host_reserve(const WorldState& world, const StepInput& input) {
  return input.host_work.learn ? world.host_work.reserve() : input.host_work.expected;
}

void classify_again(FrameReport& report, Nanoseconds lateness) {
  scheduler::LatenessFacts facts;
  facts.lateness = lateness;
  facts.mandatory = report.mandatory;
  facts.budget = report.budget;
  facts.off_cpu = report.off_cpu;
  facts.longest_overrun = report.longest_overrun;
  report.lateness = std::max(Nanoseconds(0), lateness);
  report.cause = static_cast<MissCause>(scheduler::classify(facts));
}

// What the tail will have to do with the pairs as they are.
void count_pairs(WorldState& world, FramePlan& plan) {
  const KnownCount& known = world.buffers.known_of_chunk.back();
  plan.present = known.present;
  plan.expected = likely_answered(world, plan.present);
  world.times.tail_work.coarse_contacts = known.unknown;
  world.times.tail_work = tail_work(world, plan.expected);
}

// The budget with so many substeps.
void set_budget(WorldState& world, const StepInput& input, int substeps, Nanoseconds host, FramePlan& plan) {
  scheduler::TailWork& work = world.times.tail_work;
  work.patch_visits = static_cast<std::uint64_t>(world.times.visits_a_substep * substeps);
  plan.budget = scheduler::make_frame_budget(input.budget.deadline, host, world.tail, world.margin, work, world.unit_cost_ns);
}

}  // namespace

std::uint64_t likely_answered(const WorldState& world, std::int64_t present) {
  return static_cast<std::uint64_t>(std::ceil(world.answered_share * static_cast<double>(std::max<std::int64_t>(present, 0))));
}

void begin_frame_time(WorldState& world, const StepInput& input, TimePoint start, FrameReport& report) {
  if (input.budget.kind != Budget::Kind::Deadline) return;
  TimeFacts& times = world.times;
  times.head_work = {};
  times.head_work.bodies = world.bodies.dynamic_count();
  times.head_work.contacts = times.active_pairs;
  times.head_work.candidate_pairs = times.candidate_pairs;
  scheduler::TailWork tail = times.tail_work;
  tail.bodies = world.bodies.dynamic_count();
  tail.patch_visits = static_cast<std::uint64_t>(times.visits_a_substep * world.settings.substeps);
  const Nanoseconds head = world.head.forecast(times.head_work);
  const Nanoseconds host = host_reserve(world, input);
  const Nanoseconds expected = world.tail.forecast(tail);
  report.mandatory_forecast = head + expected + host;
  report.infeasible_forecast = report.mandatory_forecast > input.budget.deadline - start;
}

FramePlan plan_frame(WorldState& world, const StepInput& input, TimePoint now, FrameReport& report) {
  const Nanoseconds host = host_reserve(world, input);
  // An infeasible frame must find room for this list without asking for it.
  world.buffers.least_seen.reserve(world.buffers.pairs.capacity());
  FramePlan plan;
  count_pairs(world, plan);
  set_budget(world, input, world.substeps, host, plan);
  // By what is expected, without the margin: where that fits and the reserve does not, nothing is refined and nothing is left out either. Leaving out for the
  // margin's sake kept frames coarse that took half of their time, and coarse frames have more to answer.
  const auto late = [&] { return now + plan.budget.tail_forecast(plan.expected) + host - input.budget.deadline; };
  if (late().count() > 0) {
    report.infeasible_forecast = true;
    Degraded degraded;
    // Where nothing rests, as in free fall, fewer substeps save nothing.
    const int least = world.times.visits_a_substep > 0 ? 1 : world.settings.substeps;
    for (int substeps = world.settings.substeps - 1; substeps >= least && late().count() > 0; --substeps) {
      set_budget(world, input, substeps, host, plan);
      degraded.substeps = substeps;
    }
    if (late().count() > 0) {
      degraded.pairs_reused = pairs_to_reuse(world, late(), world.answered_share * plan.budget.tail_per_contact_ns,
                                             world.tail.coefficients_us()[scheduler::TailForecast::kCoarseContacts]);
    }
    degrade(world, degraded);
    report.degraded = degraded;
    if (degraded.pairs_reused > 0) count_pairs(world, plan);
    set_budget(world, input, world.substeps, host, plan);
  }
  report.host_reserved = host;
  report.tail_work = world.times.tail_work;
  report.reserve_at_cut = plan.budget.reserve(plan.expected);
  report.tail_forecast = plan.budget.tail_forecast(plan.expected);
  report.cut_margin = plan.budget.margin;
  return plan;
}

void judge_time(WorldState& world, const StepInput& input, TimePoint start, Nanoseconds cpu_before, FrameReport& report) {
  report.times.total = SteadyClock::now() - start;
  if (input.budget.kind != Budget::Kind::Deadline) return;
  const StageTimes& times = report.times;
  report.budget = input.budget.deadline - start;
  report.tail_actual = times.response + times.integrate + times.publish;
  const Nanoseconds cpu = thread_cpu_time() - cpu_before;
  const Nanoseconds own = std::max(Nanoseconds(0), times.total - cpu - report.waited);
  report.off_cpu += own;
  // What the machine took of refinement is no part of the rest.
  const Nanoseconds of_refinement = world.buffers.tallies.empty() ? Nanoseconds(0) : world.buffers.tallies[0].off_cpu;
  const Nanoseconds of_rest = std::max(Nanoseconds(0), own - of_refinement);
  report.mandatory = times.total - times.refine - of_rest + report.host_reserved;
  classify_again(report, times.total + report.host_reserved - report.budget);
  // The margin is tracked against the very forecast that the reserve was made of, whatever that one did not foresee.
  world.margin.observe(report.tail_actual, report.tail_forecast);
  report.tail_beyond_clip = scheduler::beyond_clip(report.tail_actual, report.tail_forecast);
  const std::uint64_t known = world.buffers.known_of_chunk.back().present;
  const std::uint64_t present = known - std::min<std::uint64_t>(known, report.pairs_separated);
  if (present > 0) {
    world.answered_share += 0.2 * (static_cast<double>(report.contact_pairs) / static_cast<double>(present) - world.answered_share);
  }
  world.tail.learn(tail_work(world, report.contact_pairs), report.tail_actual);
  TimeFacts& facts = world.times;
  world.head.learn(facts.head_work, times.predict + times.broad_phase + times.coarse);
  facts.candidate_pairs = report.candidate_pairs;
  facts.active_pairs = report.coarse_pairs;
  std::uint64_t places = 0;
  for (const response::RestPair& pair : world.buffers.rest_pairs) places += pair.place_count;
  const double visits = static_cast<double>(world.rest_sweeps) * static_cast<double>(places);
  facts.visits_a_substep = visits / (report.degraded.substeps > 0 ? report.degraded.substeps : world.settings.substeps);
  ++facts.frames;
}

void add_host_work(Nanoseconds actual, Nanoseconds off_cpu, FrameReport& report) {
  report.host_actual = actual;
  report.mandatory += actual - off_cpu - report.host_reserved;
  report.off_cpu += off_cpu;
  classify_again(report, report.times.total + actual - report.budget);
}

void forget_times(WorldState& world, const scheduler::TimePriors& priors) {
  const double alpha = world.settings.alpha;
  const bool known = priors.frames > 0;
  world.tail = known ? scheduler::TailForecast(priors.tail_us) : scheduler::TailForecast();
  world.head = known ? scheduler::TailForecast(priors.head_us) : scheduler::TailForecast();
  // A margin that is too small is mended by a few late frames, one that is too large (that run may have had the machine to share) takes hundreds to forget.
  const double log_quantile = known && std::isfinite(priors.log_quantile) ? std::min(priors.log_quantile, first_log_quantile(alpha)) : first_log_quantile(alpha);
  world.margin = scheduler::TrackedQuantile(alpha, scheduler::TrackedQuantile::eta_for(known ? priors.spread : 0), log_quantile);
  world.host_work = scheduler::DurationForecast(alpha);
  world.unit_cost_ns = known && std::isfinite(priors.unit_cost_ns) && priors.unit_cost_ns > 0 ? priors.unit_cost_ns : kUnknownUnitCostNs;
  world.answered_share = 1;
  world.times = {};
}

scheduler::TimePriors times_of(const WorldState& world) {
  scheduler::TimePriors priors;
  priors.tail_us = world.tail.coefficients_us();
  priors.head_us = world.head.coefficients_us();
  priors.log_quantile = world.margin.log_quantile();
  priors.spread = world.margin.spread();
  priors.unit_cost_ns = world.unit_cost_ns;
  priors.frames = world.times.frames;
  return priors;
}

}  // namespace poise::simulation
