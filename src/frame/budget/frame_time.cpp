// SPDX-License-Identifier: MIT
#include "frame/budget/frame_time.h"

#include <algorithm>
#include <cmath>

#include "frame/budget/cpu_clock.h"
#include "frame/budget/degrade.h"

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
  report.cause = scheduler::classify(facts);
}

// What the tail will have to do with the pairs as they are.
void count_pairs(WorldState& world, FramePlan& plan) {
  const KnownCount& known = world.buffers.known_of_chunk.back();
  plan.present = known.present;
  plan.expected = expected_solved(world, plan.present);
  world.times.tail_work.coarse_contacts = known.unknown;
  world.times.tail_work = tail_work(world, plan.expected);
}

// Of the time that is left when all else of the tail is done, resting contact is kept at most so much for what it
// visits beyond one sweep a substep; the rest is refinement's. After that it may use what is left. Chosen.
constexpr double kShareOfIterations = 0.5;

double ns_of(Nanoseconds time) { return static_cast<double>(time.count()); }

// With a margin, what a visit of a place costs.
double iteration_ns(const WorldState& world) {
  constexpr double kLeastNs = 0.01;  // no division by nothing
  return std::max(kLeastNs,
                  world.tail.coefficients_us()[scheduler::TailForecast::kPointIterations] * world.margin.factor());
}

// Without a margin.
Nanoseconds iterations_forecast(const WorldState& world, std::uint64_t visits) {
  return Nanoseconds(static_cast<std::int64_t>(
      static_cast<double>(visits) * world.tail.coefficients_us()[scheduler::TailForecast::kPointIterations]));
}

// The visits of a substep that time is kept for.
double iterations_reserved(const WorldState& world, scheduler::TailWork work, int substeps, Nanoseconds left) {
  const TimeFacts& times = world.times;
  const auto least = static_cast<double>(times.manifold_points);
  work.point_iterations = 0;
  const double free_ns = ns_of(left) - world.margin.factor() * ns_of(world.tail.forecast(work));
  const double fit = kShareOfIterations * free_ns / (iteration_ns(world) * substeps);
  return std::min(times.iterations_a_substep, std::max(least, fit));
}

// The budget with so many substeps.
void set_budget(WorldState& world, const StepInput& input, int substeps, Nanoseconds host, TimePoint now,
                FramePlan& plan) {
  scheduler::TailWork& work = world.times.tail_work;
  const Nanoseconds left = input.budget.deadline - host - now;
  work.point_iterations = static_cast<std::uint64_t>(iterations_reserved(world, work, substeps, left) * substeps);
  plan.budget =
      scheduler::make_frame_budget(input.budget.deadline, host, world.tail, world.margin, work, world.unit_cost_ns);
}

}  // namespace

std::uint64_t expected_solved(const WorldState& world, std::int64_t present) {
  return static_cast<std::uint64_t>(
      std::ceil(world.solved_share * static_cast<double>(std::max<std::int64_t>(present, 0))));
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
  tail.point_iterations = times.manifold_points * static_cast<std::uint64_t>(world.settings.substeps);
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
  set_budget(world, input, world.substeps, host, now, plan);
  // By what is expected, without the margin: where that fits and the reserve does not, nothing is refined and nothing
  // is left out either. Leaving out for the margin's sake kept frames coarse that took half of their time, and coarse
  // frames have more to answer.
  const auto late = [&] {
    return now + world.times.planning + plan.budget.tail_forecast(plan.expected) + host - input.budget.deadline;
  };
  if (late().count() > 0) {
    report.infeasible_forecast = true;
    Degraded degraded;
    // Where nothing rests, as in free fall, fewer substeps save nothing.
    const int least = world.times.iterations_a_substep > 0 ? 1 : world.settings.substeps;
    for (int substeps = world.settings.substeps - 1; substeps >= least && late().count() > 0; --substeps) {
      set_budget(world, input, substeps, host, now, plan);
      degraded.substeps = substeps;
    }
    if (late().count() > 0) {
      degraded.pairs_reused = pairs_to_reuse(world, late(), world.solved_share * plan.budget.tail_per_contact_ns,
                                             world.tail.coefficients_us()[scheduler::TailForecast::kCoarseContacts]);
    }
    degrade(world, degraded);
    report.degraded = degraded;
    if (degraded.pairs_reused > 0) count_pairs(world, plan);
    set_budget(world, input, world.substeps, host, now, plan);
  }
  report.host_reserved = host;
  report.tail_work = world.times.tail_work;
  report.reserve_at_cut = plan.budget.reserve(plan.expected);
  report.tail_forecast = plan.budget.tail_forecast(plan.expected);
  report.cut_margin = plan.budget.margin;
  return plan;
}

std::uint32_t iterations_in_time(const WorldState& world, const StepInput& input, const FrameReport& report) {
  const TimePoint now = SteadyClock::now();
  scheduler::TailWork work = tail_work(world, report.contact_pairs);
  work.point_iterations = 0;
  const Nanoseconds spent = now - report.refine_started - report.times.refine;
  const double rest_ns = std::max(0.0, world.margin.factor() * ns_of(world.tail.forecast(work)) - ns_of(spent));
  const double left_ns = ns_of(input.budget.deadline - report.host_reserved - now) - rest_ns;
  // To the nearest whole sweep.
  const double visits =
      left_ns / (iteration_ns(world) * world.substeps) + 0.5 * static_cast<double>(world.buffers.manifold_points);
  return static_cast<std::uint32_t>(std::clamp(visits, 1.0, static_cast<double>(solver::kMaxPointIterations)));
}

void account_time(WorldState& world, const StepInput& input, TimePoint start, Nanoseconds cpu_before,
                  FrameReport& report) {
  report.times.total = SteadyClock::now() - start;
  if (input.budget.kind != Budget::Kind::Deadline) return;
  const StageTimes& times = report.times;
  const int substeps = report.degraded.substeps > 0 ? report.degraded.substeps : world.settings.substeps;
  report.budget = input.budget.deadline - start;
  report.tail_actual = times.response + times.integrate + times.publish;
  const Nanoseconds cpu = thread_cpu_time() - cpu_before;
  const Nanoseconds own = std::max(Nanoseconds(0), times.total - cpu - report.waited);
  report.off_cpu += own;
  // What the machine took of refinement is no part of the rest.
  const Nanoseconds of_refinement = world.buffers.tallies.empty() ? Nanoseconds(0) : world.buffers.tallies[0].off_cpu;
  const Nanoseconds of_rest = std::max(Nanoseconds(0), own - of_refinement);
  // Nor is what resting contact did beyond one sweep a substep.
  const std::uint64_t least_iterations = std::min<std::uint64_t>(
      report.point_iterations, world.buffers.manifold_points * static_cast<std::uint64_t>(substeps));
  const Nanoseconds of_iterations =
      std::min(times.response, iterations_forecast(world, report.point_iterations - least_iterations));
  report.mandatory = times.total - (times.refine - report.planning) - of_rest - of_iterations + report.host_reserved;
  classify_again(report, times.total + report.host_reserved - report.budget);
  // The margin is tracked against the very forecast that the reserve was made of, whatever that one did not foresee.
  // But visits beyond those that were expected were made in time that was left over.
  report.tail_left_over = iterations_forecast(
      world, report.point_iterations - std::min(report.point_iterations, report.tail_work.point_iterations));
  report.tail_forecast += report.tail_left_over;
  report.reserve_at_cut += Nanoseconds(static_cast<std::int64_t>(report.cut_margin * ns_of(report.tail_left_over)));
  world.margin.observe(report.tail_actual, report.tail_forecast);
  report.tail_beyond_clip = scheduler::beyond_clip(report.tail_actual, report.tail_forecast);
  const std::uint64_t known = world.buffers.known_of_chunk.back().present;
  const std::uint64_t present = known - std::min<std::uint64_t>(known, report.pairs_separated);
  if (present > 0) {
    world.solved_share +=
        0.2 * (static_cast<double>(report.contact_pairs) / static_cast<double>(present) - world.solved_share);
  }
  scheduler::TailWork done = tail_work(world, report.contact_pairs);
  done.point_iterations = report.point_iterations;
  world.tail.learn(done, report.tail_actual);
  TimeFacts& facts = world.times;
  world.head.learn(facts.head_work, times.predict + times.broad_phase + times.coarse);
  facts.candidate_pairs = report.candidate_pairs;
  facts.active_pairs = report.coarse_pairs;
  facts.manifold_points = world.buffers.manifold_points;
  facts.iterations_a_substep = static_cast<double>(report.point_iterations) / substeps;
  // What it would have wanted is not known. Chosen.
  if (report.degraded.point_iterations > 0)
    facts.iterations_a_substep = std::min(2 * facts.iterations_a_substep, double{solver::kMaxPointIterations});
  // Choosing what is left out takes longer than making a reserve, and who chooses must know how long.
  if (report.infeasible_forecast) facts.planning = report.planning;
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
  // A margin that is too small is mended by a few late frames, one that is too large (that run may have had the machine
  // to share) takes hundreds to forget.
  const double log_quantile = known && std::isfinite(priors.log_quantile)
                                  ? std::min(priors.log_quantile, first_log_quantile(alpha))
                                  : first_log_quantile(alpha);
  world.margin =
      scheduler::TrackedQuantile(alpha, scheduler::TrackedQuantile::eta_for(known ? priors.spread : 0), log_quantile);
  world.host_work = scheduler::DurationForecast(alpha);
  world.unit_cost_ns =
      known && std::isfinite(priors.unit_cost_ns) && priors.unit_cost_ns > 0 ? priors.unit_cost_ns : kUnknownUnitCostNs;
  world.solved_share = 1;
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
