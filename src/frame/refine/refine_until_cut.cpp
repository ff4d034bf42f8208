// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "frame/budget/cpu_clock.h"
#include "frame/budget/frame_time.h"
#include "frame/refine/open_refinement.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

std::uint64_t solved_of(double share, std::int64_t present) {
  return static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(std::max<std::int64_t>(present, 0))));
}

// Puts pairs where their turn is, and no more of them than a part of the time until the cut allows: then those of every
// k-th chunk, others in the next frame. False where that time would not do for any.
bool put_into_bands(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
                    const CompletedLevels& levels, SteadyClock::time_point start, SteadyClock::time_point cut,
                    parallel::Executor& executor) {
  // Chosen: with all pairs ranked in every frame, a pile of 10,000 whose refinement had 2 ms ended late in one frame of
  // ten.
  constexpr double kShare = 0.25;
  const PairTable& table = input.table;
  double& rank_cost_ns = resources.forecasts.rank_cost_ns;
  const double allowed_ns = kShare * static_cast<double>((cut - start).count());
  const double all_ns = rank_cost_ns * table.known_of_chunk.back().refinable;
  const auto stride = static_cast<std::size_t>(std::ceil(std::max(1.0, all_ns / std::max(allowed_ns, 1.0))));
  if (stride > std::max<std::size_t>(table.chunks(), 1)) return false;
  const std::size_t offset = input.frame % stride;
  const std::size_t count = (table.chunks() - offset + stride - 1) / stride;
  resources.bands.reset(static_cast<std::uint32_t>(table.size()));
  parallel::Shared<std::uint64_t> ranked(0);
  parallel::parallel_for(executor, count, 2, [&](std::size_t first, std::size_t past, int) {
    std::uint64_t put = 0;
    // Backwards, because the last one put into a band is the first one taken.
    for (std::size_t k = past; k-- > first;) {
      const std::size_t chunk = offset + k * stride;
      if (table.known_of_chunk[chunk].refinable == 0) continue;
      for (std::size_t i = table.end_of(chunk); i-- > table.begin_of(chunk);) {
        const PairProgress& pair = levels.progress[i];
        if (!pair.refinable()) continue;
        const auto item = static_cast<std::uint32_t>(i);
        resources.bands.put(item, scheduler::band_of(input.policy, score_of(input, facts, pair, item)));
        ++put;
      }
    }
    ranked.add(put);
  });
  if (ranked.get() >= 100) {
    const double measured_ns =
        static_cast<double>((SteadyClock::now() - start).count()) / static_cast<double>(ranked.get());
    rank_cost_ns += 0.2 * (measured_ns - rank_cost_ns);
  }
  return true;
}

}  // namespace

void refine_until_cut(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
                      CompletedLevels& levels, FrameReport& report, parallel::Executor& executor) {
  // A job that is under way at the cut may take twice its forecast before it is abandoned. Chosen.
  constexpr Nanoseconds kLeastPatience{100'000};
  const SteadyClock::time_point start = input.begun;
  Forecasts& forecasts = resources.forecasts;
  const FramePlan plan = plan_frame(input, start, forecasts, levels, report);
  OpenRefinement& open = resources.open;
  open.run.emplace(OpenRefinement::Run{input, resources.pools, resources.bands, levels, executor, facts, plan.budget,
                                       forecasts.solved_share, resources.log});
  open.hands.resize(levels.tallies.size());
  open.contacts.set(plan.present);
  open.cut.set(0);
  const scheduler::FrameBudget& budget = open.run->budget;
  const SteadyClock::time_point first_cut = budget.cut(plan.expected);
  const SteadyClock::time_point planned = SteadyClock::now();
  report.planning = planned - start;
  if (first_cut <= planned || !put_into_bands(input, resources, facts, levels, planned, first_cut, executor)) return;
  const Nanoseconds patience = std::max(kLeastPatience, 2 * budget.job_cost(input.policy.quantum_units));
  // A run ends when this thread finds nothing to take; what the others had in hand then may have left another level to
  // do.
  do {
    report.jobs_abandoned += executor.run_with({first_cut, patience}, open);
  } while (report.jobs_abandoned == 0 && open.cut.get() == 0 && !resources.bands.empty());
  report.jobs_discarded += report.jobs_abandoned;
  const SteadyClock::time_point end = SteadyClock::now();
  const std::uint64_t left = expected_solved(forecasts, open.contacts.get());
  report.reserve_at_cut = budget.reserve(left);
  report.tail_forecast = budget.tail_forecast(left);
  report.tail_work.contacts = left;
  const SteadyClock::time_point last_cut = std::max(first_cut, budget.cut(left));
  report.refine_available = last_cut - start;
  report.longest_overrun = std::max(Nanoseconds(0), end - last_cut);
  // While this thread waited for another one's job, the machine may have held that one up.
  const WorkerTally& own = levels.tallies[0];
  report.waited = own.ended == SteadyClock::time_point{} ? Nanoseconds(0) : end - own.ended;
  Nanoseconds held_up{0};
  for (std::size_t w = 1; w < levels.tallies.size(); ++w) held_up = std::max(held_up, levels.tallies[w].off_cpu);
  if (report.jobs_abandoned > 0) held_up = report.waited;
  report.off_cpu = std::min(report.waited, held_up);
}

bool OpenRefinement::operator()(int worker) {
  // Until commit() this writes what is this worker's own and nothing else.
  const auto w = static_cast<std::size_t>(worker);
  const RefineInput& input = run->input;
  const scheduler::FrameBudget& budget = run->budget;
  CompletedLevels& levels = run->levels;
  WorkerTally tally = levels.tallies[w];
  SteadyClock::time_point now = SteadyClock::now();
  if (tally.begun == SteadyClock::time_point{}) {
    tally.begun = now;
    tally.cpu_before = thread_cpu_time();
  }
  const auto admits = [&](std::uint64_t units) {
    return budget.admits(now, units, solved_of(run->solved_share, contacts.get()));
  };
  const auto end = [&](bool more) {
    tally.ended = now;
    if (!more) tally.off_cpu = std::max(Nanoseconds(0), now - tally.begun - (thread_cpu_time() - tally.cpu_before));
    levels.tallies[w] = tally;
    return more;
  };
  const std::uint32_t item = run->bands.take();
  std::uint64_t piece_units = 0;
  const bool begins =
      item != scheduler::PriorityBands::kNone &&
      admits(piece_units = std::min<std::uint64_t>(levels.progress[item].level.next_units, input.policy.quantum_units));
  if (!begins) {
    if (!run->executor.commit(worker)) return false;
    if (item != scheduler::PriorityBands::kNone) cut.set(1);
    return end(false);
  }
  const PairProgress& pair = levels.progress[item];
  collision::PairLevel& level = hands[w].level;
  collision::LevelContact& found = hands[w].found;
  level = pair.level;
  if (level.level > 0) found = levels.found[item];
  const std::uint64_t units = level.next_units;
  SteadyClock::time_point piece_begun = now;
  const auto note_piece = [&] {
    now = SteadyClock::now();
    tally.busy += now - piece_begun;
    if (now - piece_begun > tally.longest) {
      tally.longest = now - piece_begun;
      tally.longest_pair = item;
    }
    tally.overrun = std::max(tally.overrun, now - piece_begun - budget.job_cost(piece_units));
    piece_begun = now;
  };
  const Outcome outcome = complete_level(input.refiner(), run->pools, posed(input.motion, input.table.pairs[item]),
                                         level, found, worker, [&](std::uint64_t next_units) {
                                           note_piece();
                                           piece_units = next_units;
                                           return admits(next_units);
                                         });
  note_piece();
  if (!run->executor.commit(worker)) return false;
  PairProgress& mine = levels.progress[item];
  if (outcome == Outcome::Completed) {
    mine.level = level;
    levels.found[item] = found;
  }
  if (outcome == Outcome::Full) mine.full = true;
  note_outcome(mine, units, outcome, tally);
  if (run->log != nullptr) run->log->note(worker, item, kind_of(outcome), now);
  if (outcome == Outcome::Completed && mine.level.apart) contacts.add(-1);
  if (outcome == Outcome::Completed && mine.refinable()) {
    run->bands.put(item, scheduler::band_of(input.policy, score_of(input, run->facts, mine, item)));
  }
  if (outcome == Outcome::Cut) cut.set(1);
  return end(outcome != Outcome::Cut);
}

}  // namespace poise::simulation
