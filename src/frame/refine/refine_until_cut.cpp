// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <utility>

#include "frame/budget/frame_time.h"
#include "frame/refine/open_refinement.h"
#include "frame/refine/rank.h"
#include "frame/refine/score_lanes.h"
#include "parallel/cpu_clock.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

// The larger of two excesses, each with what the system took from it.
void note_overrun(Nanoseconds own, Nanoseconds off_cpu, FrameReport& report) {
  if (own + off_cpu <= report.longest_overrun + report.overrun_off_cpu) return;
  report.longest_overrun = own;
  report.overrun_off_cpu = off_cpu;
}

// What it takes to bring a pair to its end, where so many took so long.
double cost_of_pair(Nanoseconds took, std::int64_t pairs) {
  return static_cast<double>(took.count()) / static_cast<double>(pairs);
}

// Of the time that refinement has, what pairs in the order of memory may take.
double in_order_of_time(const RefineInput& input) {
  return input.slice > Nanoseconds(0) ? kInOrderOfSlices : kInOrderOfTime;
}

// Are all pairs refined as they stand in memory? Not where a host's function is to be asked for each, or what is not
// seen is to be left out.
bool goes_in_order(const RefineInput& input, const Forecasts& forecasts, const CompletedLevels& levels,
                   SteadyClock::time_point now, SteadyClock::time_point cut) {
  const scheduler::Policy& policy = input.policy;
  if (policy.kind == scheduler::PolicyKind::Custom || policy.cue.function != nullptr || policy.seen_threshold_rad > 0)
    return false;
  const double expected_ns = forecasts.pair_cost.in_order_ns * static_cast<double>(levels.known.refinable);
  return expected_ns > 0 && expected_ns < in_order_of_time(input) * static_cast<double>((cut - now).count());
}

// For all that this frame's jobs can come to, also where the machine decides whether they rank at all.
void reserve_for_jobs(const PairTable& table, std::size_t workers, const RefineResources& resources) {
  OpenRefinement& open = resources.open;
  open.batches.resize(workers);
  for (OpenRefinement::Batch& batch : open.batches) {
    batch.reserve(table.capacity());
    batch.due.clear();
  }
  open.due_pairs.reserve(table.capacity());
  open.chunks.reserve(table.known_of_chunk.capacity());
  open.chunks_of_turns.reserve(table.known_of_chunk.capacity());
  open.turns.reserve(table.capacity());
  resources.bands.reserve(static_cast<std::uint32_t>(table.capacity()));
}

// When refinement has its time.
struct RefinementTime {
  SteadyClock::time_point begin, cut;
  double in_order_of = kInOrderOfTime;  // how much of it pairs may go in the order of memory
  Nanoseconds patience{0};              // with jobs that are under way at the cut
};

// Gives this thread a chunk or a block that another worker has not come to the end of. False: there is none.
bool take_over(OpenRefinement& open) {
  OpenRefinement::Batch& own = open.batches.front();
  for (OpenRefinement::Batch& batch : open.batches) {
    if (batch.next >= batch.past) continue;
    std::swap(own.next, batch.next);
    std::swap(own.past, batch.past);
    std::swap(own.looks, batch.looks);
    return true;
  }
  return false;
}

// All pairs as they stand, until the time for that is over.
void run_in_order(const RefinementTime& time, const RefineResources& resources, std::size_t chunks, FrameReport& report,
                  parallel::Executor& executor) {
  OpenRefinement& open = resources.open;
  open.chunks_in_order.emplace(chunks, executor.concurrency());
  open.in_order_until =
      time.begin +
      Nanoseconds(static_cast<std::int64_t>(time.in_order_of * static_cast<double>((time.cut - time.begin).count())));
  for (OpenRefinement::Batch& batch : open.batches) batch.next = batch.past = 0;
  // A run ends when this thread finds no chunk; another worker may then have half of one in hand.
  do {
    report.jobs_abandoned += executor.run_with({time.cut, time.patience}, open);
  } while (report.jobs_abandoned == 0 && open.cut.get() == 0 && executor.time() < open.in_order_until &&
           take_over(open));
  // A worker that is not waited for may still look there.
  if (report.jobs_abandoned == 0) open.chunks_in_order.reset();
  const std::int64_t ended = open.ended.get();
  if (RefinementCost::tells(ended))
    resources.forecasts.pair_cost.learn(cost_of_pair(executor.time() - time.begin, ended), true);
}

// How many pairs a worker takes of the order of turns at once: about a quantum of work, so that none is left with many
// when the others have nothing.
std::uint32_t block_of(const RefineInput& input, const scheduler::FrameBudget& budget, const Forecasts& forecasts,
                       std::size_t workers) {
  constexpr double kMost = 16;
  const double pair_ns = forecasts.pair_cost.by_score_ns * static_cast<double>(workers);
  const auto quantum_ns = static_cast<double>(budget.job_cost(input.policy.quantum_units).count());
  return static_cast<std::uint32_t>(std::clamp(quantum_ns / pair_ns, 1.0, kMost));
}

// What remains of the pairs that came to no end: their contact points. In time proportional to these pairs: a look at
// all of the table would take a third of a millisecond after the cut.
void finish_points(const RefineInput& input, const RefineResources& resources, CompletedLevels& levels,
                   parallel::Executor& executor) {
  constexpr std::int64_t kLeastEntries = 1000;
  const std::int64_t due = resources.open.due.get();
  if (due == 0) return;
  const SteadyClock::time_point begun = executor.time();
  std::vector<std::uint32_t>& pairs = resources.open.due_pairs;
  pairs.clear();
  for (const OpenRefinement::Batch& batch : resources.open.batches)
    pairs.insert(pairs.end(), batch.due.begin(), batch.due.end());
  make_points_of(pairs, input, resources.pools, levels, executor);
  if (due < kLeastEntries) return;
  follow(static_cast<double>((executor.time() - begun).count()) / static_cast<double>(due),
         resources.forecasts.entry_cost_ns);
}

// What may be refined by score, until the cut. False where there was no time to rank any.
bool run_ranked(const RefineInput& input, const RefinementTime& time, const RefineResources& resources,
                CompletedLevels& levels, FrameReport& report, parallel::Executor& executor) {
  OpenRefinement& open = resources.open;
  const std::int64_t before = open.ended.get();
  const SteadyClock::time_point begin = executor.time();
  if (begin >= time.cut || !rank_pairs(input, resources, open.run->facts, begin, time.cut, levels, report, executor))
    return false;
  for (OpenRefinement::Batch& batch : open.batches) batch.next = batch.past = 0;
  const SteadyClock::time_point ranked = executor.time();
  // A run ends when this thread finds nothing to take; what the others had in hand then may have left another level to
  // do, and they may not have come to the end of it.
  do {
    report.jobs_abandoned += executor.run_with({time.cut, time.patience}, open);
  } while (report.jobs_abandoned == 0 && open.cut.get() == 0 && (take_over(open) || !resources.bands.empty()));
  const std::int64_t ended = open.ended.get() - before;
  Forecasts& forecasts = resources.forecasts;
  if (RefinementCost::tells(ended, before > 0 ? levels.known.refinable : 0U))
    forecasts.pair_cost.learn(cost_of_pair(executor.time() - ranked, ended) + forecasts.rank_cost_ns, false);
  return true;
}

// False where nothing was run at all.
bool run_jobs(const RefineInput& input, const RefineResources& resources, CompletedLevels& levels,
              const RefinementTime& time, FrameReport& report, parallel::Executor& executor) {
  const bool in_order = goes_in_order(input, resources.forecasts, levels, time.begin, time.cut);
  if (in_order) run_in_order(time, resources, input.table.chunks(), report, executor);
  const bool more = resources.open.ended.get() < static_cast<std::int64_t>(levels.known.refinable);
  const bool ranked =
      report.jobs_abandoned == 0 && more && run_ranked(input, time, resources, levels, report, executor);
  return in_order || ranked;
}

}  // namespace

void refine_until_cut(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
                      CompletedLevels& levels, FrameReport& report, parallel::Executor& executor) {
  // A job that is under way at the cut may take twice its forecast before it is abandoned. Chosen.
  constexpr Nanoseconds kLeastPatience{100'000};
  const SteadyClock::time_point start = input.begun;
  Forecasts& forecasts = resources.forecasts;
  levels.waits = {};
  levels.off_cpu = Nanoseconds(0);
  const FramePlan plan = plan_frame(input, start, forecasts, levels, report, executor);
  OpenRefinement& open = resources.open;
  open.run.emplace(OpenRefinement::Run{input, resources.pools, resources.bands, levels, executor, facts, plan.budget,
                                       forecasts.solved_share,
                                       block_of(input, plan.budget, forecasts, levels.tallies.size()),
                                       forecasts.entry_cost_ns, !scores_in_lanes(input.policy), resources.log});
  open.cues.emplace(open.run->input);
  reserve_for_jobs(input.table, levels.tallies.size(), resources);
  open.contacts.set(plan.present);
  open.ended.set(0);
  open.due.set(0);
  levels.present = plan.present;
  open.cut.set(0);
  open.chunks_in_order.reset();
  const scheduler::FrameBudget& budget = open.run->budget;
  const SteadyClock::time_point first_cut = budget.cut(plan.expected);
  const SteadyClock::time_point planned = executor.time();
  report.planning = planned - start;
  if (first_cut <= planned) return;
  const Nanoseconds patience = std::max(kLeastPatience, 2 * budget.job_cost(input.policy.quantum_units));
  const parallel::Waits waits_before = executor.waits();
  const Nanoseconds cpu_before = parallel::thread_cpu_time();
  const SteadyClock::time_point run_begun = executor.time();
  const bool ran =
      run_jobs(input, resources, levels, {planned, first_cut, in_order_of_time(input), patience}, report, executor);
  const SteadyClock::time_point end = executor.time();
  const Nanoseconds own_cpu = parallel::thread_cpu_time() - cpu_before;
  if (!ran) {
    levels.off_cpu = std::max(Nanoseconds(0), end - run_begun - own_cpu);
    return;
  }
  report.jobs_discarded += report.jobs_abandoned;
  levels.waits = executor.waits() - waits_before;
  levels.present = open.contacts.get();
  const std::uint64_t left = expected_solved(forecasts, levels.present);
  report.reserve_at_cut = budget.reserve(left);
  report.tail_forecast = budget.tail_forecast(left);
  report.tail_work.contacts = left;
  const SteadyClock::time_point last_cut = std::max(first_cut, budget.cut(left));
  report.refine_available = last_cut - start;
  // While this thread waited for another one's job, the machine may have held that one up.
  const WorkerTally& own = levels.tallies[0];
  report.waited = own.ended == SteadyClock::time_point{} ? Nanoseconds(0) : end - own.ended;
  // Or everyone, once nobody had anything to do.
  Nanoseconds held_up = report.waited;
  for (const WorkerTally& tally : levels.tallies) {
    if (tally.ended != SteadyClock::time_point{}) held_up = std::min(held_up, end - tally.ended);
  }
  for (std::size_t w = 1; w < levels.tallies.size(); ++w) held_up = std::max(held_up, levels.tallies[w].off_cpu);
  if (report.jobs_abandoned > 0) held_up = report.waited;
  report.off_cpu = std::min(report.waited, held_up);
  levels.off_cpu = std::max(Nanoseconds(0), end - run_begun - own_cpu - report.waited);
  const Nanoseconds of_points = time_of_points(forecasts.entry_cost_ns, open.due.get());
  const Nanoseconds past_cut = std::max(Nanoseconds(0), end + of_points - last_cut);
  const Nanoseconds taken = std::min(past_cut, levels.off_cpu + report.off_cpu);
  note_overrun(past_cut - taken, taken, report);
  for (const WorkerTally& tally : levels.tallies) note_overrun(tally.overrun, tally.overrun_off_cpu, report);
  finish_points(input, resources, levels, executor);
}

}  // namespace poise::simulation
