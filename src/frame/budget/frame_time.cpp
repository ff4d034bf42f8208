// SPDX-License-Identifier: MIT
#include "frame/budget/frame_time.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "frame/budget/degrade.h"
#include "frame/budget/hold.h"
#include "math/functions.h"
#include "solver/solver.h"

namespace poise::simulation {
namespace {

// How much of what is learned of a frame's cost comes from the last one. Chosen.
constexpr double kNewShare = 0.25;

// Where the margin begins when nothing is known: half as much again at 1 %, twice as much at 0.1 %. Chosen.
double first_log_quantile(double alpha) {
  return 0.4 + 0.3 * std::clamp(math::log(0.01 / alpha) / std::numbers::ln10, -1.0, 3.0);
}

Nanoseconds host_reserve(const Forecasts& forecasts, const StepInput& step) {
  return step.host_work.learn ? forecasts.host_work.reserve() : step.host_work.expected;
}

void classify_again(FrameReport& report, Nanoseconds lateness) {
  scheduler::LatenessFacts facts;
  facts.lateness = lateness;
  facts.mandatory = report.mandatory;
  facts.release_delay = report.release_delay;
  facts.budget = report.budget + report.release_delay;
  facts.off_cpu = report.off_cpu;
  facts.longest_overrun = report.longest_overrun;
  facts.overrun_off_cpu = report.overrun_off_cpu;
  report.lateness = std::max(Nanoseconds(0), lateness);
  report.cause = scheduler::classify(facts);
}

// Before refinement, by the counts of the frame before.
scheduler::TailWork head_work(const TimeFacts& times, std::size_t dynamic_bodies) {
  scheduler::TailWork work;
  work.bodies = dynamic_bodies;
  work.contacts = times.active_pairs;
  work.candidate_pairs = times.candidate_pairs;
  return work;
}

// After the iterations of resting contact.
scheduler::TailWork rest_work(const FrameCounts& counts, std::size_t contacts) {
  scheduler::TailWork work;
  work.bodies = counts.dynamic_bodies - counts.levels.held.bodies;
  work.contacts = contacts;
  work.candidate_pairs = counts.table.size();
  return work;
}

FrameCounts counts_of(const RefineInput& input, const CompletedLevels& levels) {
  return {input.terms.contact, input.scene.bodies.dynamic_count(), input.substeps, input.table, levels};
}

double ns_of(Nanoseconds time) { return static_cast<double>(time.count()); }

// What the tail will have to do with the pairs as they are.
void count_pairs(const RefineInput& input, const CompletedLevels& levels, Forecasts& forecasts, FramePlan& plan) {
  plan.present = levels.known.present;
  plan.expected = expected_solved(forecasts, plan.present);
  forecasts.times.tail_work.coarse_contacts = levels.known.unknown;
  forecasts.times.tail_work = tail_work(forecasts, counts_of(input, levels), plan.expected);
  // No more than refinement could find in the whole of the time that is left.
  const double could = ns_of(plan.time_left) / forecasts.pair_cost.by_score_ns;
  const double open = std::min(static_cast<double>(levels.held.open), std::max(0.0, could));
  forecasts.times.tail_work.held_found = expected_solved(forecasts, static_cast<std::int64_t>(open));
}

// Of the time that is left when all else of the tail is done, the contact solver is given at most so much for what it
// iterates beyond once a substep; the rest is refinement's. After that it may use what is left. Chosen.
constexpr double kShareOfIterations = 0.5;

// What point iterations beyond one a substep take. Those that take longer are stopped by the clock, so there is no
// margin.
Nanoseconds iterations_forecast(const Forecasts& forecasts, double iterations) {
  return Nanoseconds(static_cast<std::int64_t>(iterations * forecasts.iteration_ns));
}

// They took so long.
void learn_iterations(Nanoseconds took, std::uint64_t iterations, Forecasts& forecasts) {
  constexpr std::uint64_t kLeast = 1000;
  if (iterations < kLeast || took <= Nanoseconds(0)) return;
  follow(ns_of(took) / static_cast<double>(iterations), forecasts.iteration_ns);
}

// The point iterations of a substep that time is reserved for. `share`: of the contacts that do not wait.
double iterations_reserved(const Forecasts& forecasts, scheduler::TailWork work, int substeps, Nanoseconds left,
                           double share) {
  const TimeFacts& times = forecasts.times;
  const double least = share * static_cast<double>(times.manifold_points);
  work.point_iterations = 0;
  const double free_ns = ns_of(left) - forecasts.margin.factor() * ns_of(forecasts.tail.forecast(work));
  const double fit = kShareOfIterations * free_ns / (forecasts.iteration_ns * substeps);
  return std::min(share * times.iterations_a_substep, std::max(least, fit));
}

// The budget with so many substeps.
void set_budget(int substeps, Nanoseconds host, SteadyClock::time_point now, Forecasts& forecasts, FramePlan& plan) {
  scheduler::TailWork& work = forecasts.times.tail_work;
  const Nanoseconds left = plan.deadline - host - now;
  const double all = iterations_reserved(forecasts, work, substeps, left, plan.share) * substeps;
  const double least = std::min(all, plan.share * static_cast<double>(forecasts.times.manifold_points) * substeps);
  work.point_iterations = static_cast<std::uint64_t>(least);
  plan.budget =
      scheduler::make_frame_budget(plan.deadline, host, forecasts.tail, forecasts.margin, work, forecasts.unit_cost.ns);
  plan.budget.tail_optional = iterations_forecast(forecasts, all - least);
}

// Islands wait until there is time for so much of what refinement has to do. What was found of a pair goes out of date
// as its bodies move: a heap that lands with time for a quarter sinks by a twentieth, and creeps (docs/scheduling.md).
// How much of it a policy leaves out is not known.
Nanoseconds least_refined(const scheduler::Policy& policy, double all_ns) {
  constexpr double kLeast = 1.0 / 3;  // chosen
  return Nanoseconds(scheduler::leaves_out(policy) ? 0 : static_cast<std::int64_t>(kLeast * all_ns));
}

// The time that refinement is to have in a step in slices: for its share by score, or for all pairs in the order of
// memory where that does not take much longer.
double wanted_in_slices_ns(const RefinementCost& cost, double refinable) {
  constexpr double kMuch = 1.75;  // chosen
  const double by_score_ns = kRefinedInSlices * cost.by_score_ns * refinable;
  const double in_order_ns = cost.in_order_ns * refinable / kInOrderOfSlices;
  return in_order_ns > 0 && in_order_ns < kMuch * by_score_ns ? std::max(in_order_ns, by_score_ns) : by_score_ns;
}

// Of a step in slices: that of the first after which what must be done fits, and what refinement is to have. To its
// end, since what is left of a frame in which a step ends is lost.
SteadyClock::time_point end_of_slices(const RefineInput& input, SteadyClock::time_point now, const Forecasts& forecasts,
                                      double refinable, const FramePlan& plan) {
  const Nanoseconds optional = std::min(plan.budget.tail_optional, input.slice);
  const Nanoseconds tail =
      std::max(plan.budget.reserve(plan.expected), plan.budget.tail_forecast(plan.expected) + optional);
  const double wanted_ns = ns_of(now - input.step_begun + forecasts.times.planning + tail) +
                           wanted_in_slices_ns(forecasts.pair_cost, refinable);
  const double slices = std::ceil(wanted_ns / ns_of(input.slice));
  const SteadyClock::time_point last = input.step.budget.deadline;
  if (slices * ns_of(input.slice) >= ns_of(last - input.step_begun)) return last;
  return input.step_begun + static_cast<int>(slices) * input.slice;
}

int substeps_of(const RefineInput& input, const CompletedLevels& levels) {
  return levels.substeps > 0 ? levels.substeps : input.substeps;
}

// Lets islands wait, once a frame, until the tail is shorter by so much.
void hold(const RefineInput& input, Nanoseconds missing, Forecasts& forecasts, CompletedLevels& levels,
          Degraded& degraded, FramePlan& plan, parallel::Executor& executor) {
  if (degraded.bodies_held > 0) return;
  constexpr double kLeastNs = 1;
  const double solved = ns_of(missing) / std::max(kLeastNs, plan.budget.tail_per_contact_ns);
  const double contacts = std::ceil(solved / std::max(1e-3, forecasts.solved_share));
  const auto before = static_cast<double>(levels.known.present);
  degraded.bodies_held = hold_islands(input, static_cast<std::uint64_t>(std::min(contacts, before)), levels, executor);
  if (degraded.bodies_held == 0) return;
  plan.share = static_cast<double>(levels.known.present) / before;
  count_pairs(input, levels, forecasts, plan);
}

// Makes room for refinement: islands wait where the forecast leaves it less than it is to have, or the reserve not
// enough for a third of its pairs; and where the reserve leaves it less than it is to have, it gets that out of the
// margin.
void make_room(const RefineInput& input, Nanoseconds host, SteadyClock::time_point now, Forecasts& forecasts,
               CompletedLevels& levels, Degraded& degraded, FramePlan& plan, parallel::Executor& executor) {
  const double all_ns = forecasts.pair_cost.by_score_ns * levels.known.refinable;
  const Nanoseconds share = share_of_refinement(all_ns, plan.deadline - now);
  if (share <= Nanoseconds(0)) return;
  // Out of the margin, but not all of it: a tail takes longer than its forecast as often as not.
  const auto give_share = [&] {
    const Nanoseconds forecast = plan.budget.tail_forecast(plan.expected);
    const double left_ns = kMarginLeft * std::max(plan.budget.margin - 1, 0.0) * ns_of(forecast);
    const auto fits = plan.deadline - host - forecast - Nanoseconds(static_cast<std::int64_t>(left_ns));
    plan.budget.earliest_cut = std::min(now + share, fits);
  };
  give_share();
  const SteadyClock::time_point wanted = now + std::max(share, least_refined(input.policy, all_ns));
  const SteadyClock::time_point cut = plan.budget.cut(plan.expected);
  if (cut >= wanted) return;
  hold(input, wanted - cut, forecasts, levels, degraded, plan, executor);
  set_budget(substeps_of(input, levels), host, now, forecasts, plan);
  give_share();
}

}  // namespace

scheduler::TailWork tail_work(const Forecasts& forecasts, const FrameCounts& counts, std::uint64_t contacts) {
  scheduler::TailWork work = forecasts.times.tail_work;
  work.sphere_contacts = 0;
  work.bodies = counts.dynamic_bodies - counts.levels.held.bodies;
  work.contacts = contacts;
  work.candidate_pairs = counts.table.size() - counts.levels.held.pairs;
  work.held_pairs = counts.levels.held.pairs;
  work.held_found = counts.held_found;
  if (counts.contact == ContactModel::Paper) {
    for (const PairProgress& pair : counts.levels.progress) {
      if (!pair.apart() && !pair.held && !pair.by_polygons()) work.sphere_contacts += pair.level.front_entries;
    }
  }
  return work;
}

std::uint64_t expected_solved(const Forecasts& forecasts, std::int64_t present) {
  return static_cast<std::uint64_t>(
      std::ceil(forecasts.solved_share * static_cast<double>(std::max<std::int64_t>(present, 0))));
}

Nanoseconds mandatory_forecast(const StepInput& step, std::size_t dynamic_bodies, int substeps,
                               const Forecasts& forecasts) {
  const TimeFacts& times = forecasts.times;
  scheduler::TailWork tail = times.tail_work;
  tail.bodies = dynamic_bodies;
  tail.candidate_pairs += std::exchange(tail.held_pairs, 0);
  tail.held_found = 0;
  tail.point_iterations = times.manifold_points * static_cast<std::uint64_t>(substeps);
  return forecasts.head.forecast(head_work(times, dynamic_bodies)) + forecasts.tail.forecast(tail) +
         host_reserve(forecasts, step);
}

Nanoseconds share_of_refinement(double all_ns, Nanoseconds left) {
  constexpr double kShare = 0.2;  // chosen
  return Nanoseconds(static_cast<std::int64_t>(std::min(kShare * ns_of(left), all_ns)));
}

Nanoseconds time_of_step(const StepInput& step, SteadyClock::time_point now, const Forecasts& forecasts) {
  return step.budget.deadline - host_reserve(forecasts, step) - now;
}

void begin_frame_time(const StepInput& step, std::size_t dynamic_bodies, int substeps, SteadyClock::time_point start,
                      Forecasts& forecasts, FrameReport& report) {
  if (step.budget.kind != Budget::Kind::Deadline) return;
  forecasts.times.head_work = head_work(forecasts.times, dynamic_bodies);
  report.mandatory_forecast = mandatory_forecast(step, dynamic_bodies, substeps, forecasts);
  report.infeasible_forecast = report.mandatory_forecast > step.budget.deadline - start;
}

std::uint32_t crowded_partners_in_time(const StepInput& step, std::size_t dynamic_bodies, std::uint32_t most,
                                       SteadyClock::time_point now, const Forecasts& forecasts) {
  if (step.budget.kind != Budget::Kind::Deadline || dynamic_bodies == 0) return 0;
  // What a pair costs is not known well: in the frames that it is learned from, bodies and pairs grow together.
  constexpr double kLeastNs = 200, kMostNs = 5000;
  const scheduler::TailForecast::Features head = forecasts.head.coefficients_us();
  const scheduler::TailForecast::Features tail = forecasts.tail.coefficients_us();
  using Tail = scheduler::TailForecast;
  // Microseconds a thousand are nanoseconds each.
  const double pair_ns = std::clamp(head[Tail::kCandidatePairs] + head[Tail::kContacts] + tail[Tail::kCandidatePairs] +
                                        forecasts.solved_share * (tail[Tail::kContacts] + tail[Tail::kCoarseContacts]),
                                    kLeastNs, kMostNs);
  scheduler::TailWork bodies;
  bodies.bodies = dynamic_bodies;
  const Nanoseconds of_bodies = forecasts.head.forecast(bodies) + forecasts.tail.forecast(bodies);
  const double left_ns = std::max(0.0, ns_of(step.budget.deadline - host_reserve(forecasts, step) - now - of_bodies));
  const double partners = left_ns / (pair_ns * static_cast<double>(dynamic_bodies));
  return partners < most ? std::max(1U, static_cast<std::uint32_t>(partners)) : 0;
}

FramePlan plan_frame(const RefineInput& input, SteadyClock::time_point now, Forecasts& forecasts,
                     CompletedLevels& levels, FrameReport& report, parallel::Executor& executor) {
  const StepInput& step = input.step;
  const Nanoseconds host = host_reserve(forecasts, step);
  // An infeasible frame must find memory for this list without asking for it.
  levels.reused.reserve(input.table.capacity());
  levels.reuse_band.reserve(input.table.capacity());
  levels.held.reserve(input.scene.bodies.slot_count());
  levels.islands.reserve(input.scene.bodies.slot_count());
  FramePlan plan;
  plan.deadline = step.budget.deadline;
  plan.time_left = plan.deadline - host - now;
  plan.threads = executor.concurrency();
  count_pairs(input, levels, forecasts, plan);
  set_budget(input.substeps, host, now, forecasts, plan);
  if (input.slice > Nanoseconds(0)) {
    plan.deadline = end_of_slices(input, now, forecasts, levels.known.refinable, plan);
    plan.time_left = plan.deadline - host - now;
    set_budget(input.substeps, host, now, forecasts, plan);
  }
  levels.deadline = plan.deadline;
  // By what is expected, without the margin: where that fits and the reserve does not, nothing is refined and nothing
  // is left out either. Leaving out for the margin's sake held frames coarse that took half of their time, and coarse
  // frames have more contacts to solve.
  const auto late = [&] {
    return now + forecasts.times.planning + plan.budget.tail_forecast(plan.expected) + host - plan.deadline;
  };
  if (late().count() > 0) {
    report.infeasible_forecast = true;
    Degraded degraded;
    hold(input, late(), forecasts, levels, degraded, plan, executor);
    set_budget(substeps_of(input, levels), host, now, forecasts, plan);
    // Where nothing rests, as in free fall, fewer substeps save nothing.
    const int least = forecasts.times.iterations_a_substep > 0 ? 1 : input.substeps;
    for (int substeps = input.substeps - 1; substeps >= least && late().count() > 0; --substeps) {
      set_budget(substeps, host, now, forecasts, plan);
      degraded.substeps = substeps;
    }
    use_substeps(input, degraded.substeps, levels);
    if (late().count() > 0) {
      const double coarse_ns = forecasts.tail.coefficients_us()[scheduler::TailForecast::kCoarseContacts];
      degraded.pairs_reused = choose_reused(input, late(), forecasts.solved_share * plan.budget.tail_per_contact_ns,
                                            coarse_ns, levels, executor);
    }
    degrade(input, degraded, levels, executor);
    report.degraded = degraded;
    if (degraded.pairs_reused > 0) count_pairs(input, levels, forecasts, plan);
    set_budget(substeps_of(input, levels), host, now, forecasts, plan);
  }
  make_room(input, host, now, forecasts, levels, report.degraded, plan, executor);
  report.host_reserved = host;
  report.tail_work = forecasts.times.tail_work;
  report.reserve_at_cut = plan.budget.reserve(plan.expected);
  report.tail_forecast = plan.budget.tail_forecast(plan.expected);
  report.cut_margin = plan.budget.margin;
  return plan;
}

std::uint32_t iterations_in_time(const Forecasts& forecasts, SteadyClock::time_point deadline,
                                 const FrameCounts& counts, SteadyClock::time_point now, std::uint64_t manifold_points,
                                 const FrameReport& report) {
  scheduler::TailWork work = tail_work(forecasts, counts, report.contact_pairs);
  work.point_iterations = 0;
  const Nanoseconds spent = now - report.refine_started - report.times.refine;
  const double rest_ns = std::max(0.0, ns_of(forecasts.tail.forecast(work)) - ns_of(spent));
  const double left_ns = ns_of(deadline - report.host_reserved - now) - rest_ns;
  const int substeps = counts.levels.substeps > 0 ? counts.levels.substeps : counts.substeps;
  // To the nearest whole iteration over all points.
  const double iterations = left_ns / (forecasts.iteration_ns * substeps) + 0.5 * static_cast<double>(manifold_points);
  return static_cast<std::uint32_t>(std::clamp(iterations, 1.0, static_cast<double>(solver::kMaxPointIterations)));
}

SteadyClock::time_point iterations_end(const Forecasts& forecasts, SteadyClock::time_point deadline,
                                       const FrameCounts& counts, const FrameReport& report) {
  constexpr double kMostNs = 1e18;  // far beyond any frame, and within the range of Nanoseconds
  const Nanoseconds rest = forecasts.rest.forecast(rest_work(counts, report.contact_pairs));
  const double rest_ns = std::min(kMostNs, forecasts.margin.factor() * ns_of(rest));
  return deadline - report.host_reserved - Nanoseconds(static_cast<std::int64_t>(rest_ns));
}

void account_time(const StepInput& step, const FrameCounts& counts, std::uint64_t manifold_points,
                  const CallerTime& caller, Forecasts& forecasts, FrameReport& report) {
  if (step.budget.kind != Budget::Kind::Deadline) return;
  const StageTimes& times = report.times;
  const int substeps = report.degraded.substeps > 0 ? report.degraded.substeps : counts.substeps;
  report.budget = step.budget.deadline - report.started;
  report.tail_actual = times.manifolds + times.solve + times.integrate + times.publish;
  report.waited += caller.waits.slept;
  const Nanoseconds own = std::max(Nanoseconds(0), times.total - caller.cpu - report.waited);
  report.off_cpu += own + caller.waits.held_up;
  // What the machine took of refinement is no part of the rest.
  const Nanoseconds of_refinement = counts.levels.off_cpu;
  // Nor is what the contact solver iterated beyond once a substep.
  report.tail_optional = std::min(times.solve, std::exchange(forecasts.times.iterated, Nanoseconds(0)));
  const Nanoseconds rest = times.total - (times.refine - report.planning) - report.tail_optional;
  const Nanoseconds of_rest = std::max(Nanoseconds(0), own - of_refinement) + caller.waits.held_up;
  // What was taken of these iterations is known only as a part of all.
  report.mandatory = std::max(Nanoseconds(0), rest - of_rest) + report.host_reserved;
  classify_again(report, times.total + report.host_reserved - report.budget);
  // The margin is tracked against the very forecast that the reserve was made of, whatever that one did not foresee.
  forecasts.margin.observe(report.tail_needed(), report.tail_forecast);
  report.tail_beyond_clip = scheduler::beyond_clip(report.tail_needed(), report.tail_forecast);
  const std::int64_t present = counts.levels.present;
  if (present > 0) {
    forecasts.solved_share +=
        0.2 * (static_cast<double>(report.contact_pairs) / static_cast<double>(present) - forecasts.solved_share);
  }
  scheduler::TailWork done = tail_work(forecasts, counts, report.contact_pairs);
  done.point_iterations =
      std::min<std::uint64_t>(report.point_iterations, manifold_points * static_cast<std::uint64_t>(substeps));
  forecasts.tail.learn(done, report.tail_needed());
  learn_iterations(report.tail_optional, report.point_iterations - done.point_iterations, forecasts);
  const auto iterations_end = std::exchange(forecasts.times.iterations_end, SteadyClock::time_point{});
  if (iterations_end != SteadyClock::time_point{})
    forecasts.rest.learn(rest_work(counts, report.contact_pairs), report.started + times.total - iterations_end);
  TimeFacts& facts = forecasts.times;
  forecasts.head.learn(facts.head_work, times.predict + times.broad_phase + times.coarse);
  facts.candidate_pairs = report.candidate_pairs;
  facts.active_pairs = counts.table.size();
  facts.load = counts.dynamic_bodies + facts.active_pairs;
  if (facts.load > 0) {
    // What was refined, and what was left.
    const Nanoseconds refined = std::max(Nanoseconds(0), times.refine - report.planning - of_refinement);
    const double left_ns =
        counts.leaves_out ? 0 : forecasts.pair_cost.by_score_ns * static_cast<double>(report.pairs_left);
    const double wanted_ns = ns_of(report.mandatory - report.host_reserved + refined) + left_ns;
    const double one_ns = wanted_ns / static_cast<double>(facts.load);
    facts.ns_of_load = facts.ns_of_load > 0 ? facts.ns_of_load + kNewShare * (one_ns - facts.ns_of_load) : one_ns;
  }
  // What waits will want what it wanted when it was stepped last.
  if (report.degraded.bodies_held == 0) {
    facts.manifold_points = manifold_points;
    facts.iterations_a_substep = static_cast<double>(report.point_iterations) / substeps;
  }
  // What it would have wanted is not known. Chosen.
  if (report.degraded.bodies_held == 0 && report.degraded.point_iterations > 0)
    facts.iterations_a_substep = std::min(2 * facts.iterations_a_substep, double{solver::kMaxPointIterations});
  // Choosing what is left out takes longer than making a reserve, and who chooses must know how long.
  if (report.infeasible_forecast) facts.planning = report.planning;
  ++facts.frames;
}

void account_slice(const StepInput& step, const CallerTime& caller, FrameReport& report) {
  report.waited = caller.waits.slept;
  if (step.budget.kind != Budget::Kind::Deadline) return;
  report.budget = step.budget.deadline - report.started;
  report.off_cpu = std::max(Nanoseconds(0), report.times.total - caller.cpu - report.waited) + caller.waits.held_up;
  // What is left over goes on in the next frame, so nothing is infeasible.
  report.mandatory = report.host_reserved;
  report.longest_overrun = report.overrun_off_cpu = {};
  classify_again(report, report.times.total + report.host_reserved - report.budget);
}

void add_host_work(Nanoseconds actual, Nanoseconds off_cpu, FrameReport& report) {
  report.host_actual = actual;
  report.mandatory += actual - off_cpu - report.host_reserved;
  report.off_cpu += off_cpu;
  classify_again(report, report.times.total + actual - report.budget);
}

void forget_times(Forecasts& forecasts, double alpha, const scheduler::TimePriors& priors) {
  const bool known = priors.frames > 0;
  forecasts.tail = known ? scheduler::TailForecast(priors.tail_us) : scheduler::TailForecast();
  forecasts.head = known ? scheduler::TailForecast(priors.head_us) : scheduler::TailForecast();
  // A part of the tail; nothing is known of how much. Chosen.
  scheduler::TailForecast::Features rest_us = forecasts.tail.coefficients_us();
  for (double& us : rest_us) us *= 0.5;
  forecasts.rest = scheduler::TailForecast(rest_us);
  // A margin that is too small is mended by a few late frames, one that is too large (that run may have had the machine
  // to share) takes hundreds to forget.
  const double log_quantile = known && std::isfinite(priors.log_quantile)
                                  ? std::min(priors.log_quantile, first_log_quantile(alpha))
                                  : first_log_quantile(alpha);
  forecasts.margin =
      scheduler::TrackedQuantile(alpha, scheduler::TrackedQuantile::eta_for(known ? priors.spread : 0), log_quantile);
  forecasts.host_work = scheduler::DurationForecast(alpha);
  // What a unit takes at most; more was a machine that had other things to do. Chosen.
  constexpr double kMostUnitCostNs = 1e4;
  forecasts.unit_cost = {};
  if (known && priors.unit_cost_ns > 0 && priors.unit_cost_ns <= kMostUnitCostNs)
    forecasts.unit_cost.ns = priors.unit_cost_ns;
  forecasts.solved_share = 1;
  forecasts.times = {};
}

scheduler::TimePriors times_of(const Forecasts& forecasts) {
  scheduler::TimePriors priors;
  priors.tail_us = forecasts.tail.coefficients_us();
  priors.head_us = forecasts.head.coefficients_us();
  priors.log_quantile = forecasts.margin.log_quantile();
  priors.spread = forecasts.margin.spread();
  priors.unit_cost_ns = forecasts.unit_cost.ns;
  priors.frames = forecasts.times.frames;
  return priors;
}

}  // namespace poise::simulation
