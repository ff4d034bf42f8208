// SPDX-License-Identifier: MIT
#include "frame/refine/refine.h"

#include <algorithm>
#include <limits>

#include "frame/cues/prepared_cues.h"
#include "frame/refine/observe_gains.h"
#include "frame/refine/pair_cues.h"
#include "frame/refine/rank.h"
#include "frame/refine/replay_decisions.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kCopyGrain = 1024;

// A refinement on the work clock, or without a limit.
struct Refinement {
  const RefineInput& input;
  const RefineResources& resources;
  scheduler::FrameFacts facts;
  CompletedLevels& levels;
  parallel::Executor& executor;

  [[nodiscard]] collision::PairFrame frame_of_pair(std::uint32_t index) const {
    return frame_of(input.refiner(), posed(input.motion, input.table.pairs[index]));
  }
  Outcome refine_next(std::uint32_t index, collision::PairFrame& frame, int worker) const {
    return refine_level(input.refiner(), posed(input.motion, input.table.pairs[index]), frame, levels.progress[index],
                        levels.found, resources.pools, worker);
  }
};

// Of pools of fronts.
struct FrontRoom {
  std::uint64_t entries = 0, segments = 0;
  [[nodiscard]] bool holds(const FrontRoom& needed) const {
    return needed.entries <= entries && needed.segments <= segments;
  }
  friend FrontRoom operator+(const FrontRoom& a, const FrontRoom& b) {
    return {a.entries + b.entries, a.segments + b.segments};
  }
};

// What the next level of a pair may take at most.
FrontRoom worst_of(const collision::PairLevel& level, std::uint64_t units) {
  // Polygons make no front.
  if (level.next_is_polygons()) return {};
  // All pairs of children of each entry, and the nearest of them once more; each entry in a run of its own, which makes
  // a segment of each of the two lists.
  return {units * (kTreeBranching * kTreeBranching + 1), units * 2};
}

// What one pool would have left if all that is in them were in it.
FrontRoom room_in(std::span<const collision::FrontPool> pools, std::uint32_t max_entries) {
  FrontRoom used;
  for (const collision::FrontPool& pool : pools) used = used + FrontRoom{pool.mark().entries, pool.mark().segments};
  const std::uint64_t segments = collision::FrontPool::segments_for(max_entries);
  return {max_entries - std::min<std::uint64_t>(max_entries, used.entries),
          segments - std::min(segments, used.segments)};
}

// The work clock, and no limit at all: rounds whose members depend on scores and charges alone.
void refine_by_rounds(const Refinement& refinement, std::uint64_t budget_units) {
  constexpr std::size_t kRoundGrain = 8;
  const RefineInput& input = refinement.input;
  scheduler::RoundSelector& rounds = refinement.resources.rounds;
  parallel::UnsetVector<PairProgress>& all = refinement.levels.progress;
  const auto candidate = [&](std::uint32_t index) {
    return scheduler::Candidate{score_of(input, refinement.facts, refinement.levels.cues[index], all[index],
                                         refinement.levels.found.of(all[index]).contact, index),
                                index, all[index].level.next_units};
  };
  const auto add = [&](std::uint32_t index) {
    const scheduler::Candidate next = candidate(index);
    all[index].turn = turn_at(scheduler::band_of(input.policy, next.score));
    if (!scheduler::left_out(input.policy, next.score)) {
      rounds.add(next);
    } else {
      all[index].stop = Stop::Unseen;
    }
  };
  rounds.begin_frame(budget_units, all.size(), input.policy.round_pairs);
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    if (all[i].refinable()) add(i);
  }
  for (;;) {
    const std::span<const scheduler::Candidate> round = rounds.next_round();
    if (round.empty()) break;
    // Whether fronts fit is decided from worst cases beforehand, not by whose pool fills up first: a result must not
    // depend on threads. In slices whose worst cases fit.
    for (std::size_t first = 0; first < round.size();) {
      const FrontRoom room = room_in(refinement.resources.pools, input.max_front_entries);
      FrontRoom worst;
      std::size_t end = first;
      for (; end < round.size(); ++end) {
        PairProgress& pair = all[round[end].pair];
        const FrontRoom with_it = worst + worst_of(pair.level, round[end].units);
        if (!room.holds(with_it) && end > first) break;
        pair.full = !room.holds(with_it);
        if (!pair.full) worst = with_it;
      }
      const std::span<const scheduler::Candidate> slice = round.subspan(first, end - first);
      parallel::parallel_for(refinement.executor, slice.size(), kRoundGrain,
                             [&](std::size_t begin, std::size_t past, int worker) {
                               for (std::size_t i = begin; i < past; ++i) {
                                 PairProgress& pair = all[slice[i].pair];
                                 const std::uint64_t units = pair.level.next_units;
                                 Outcome outcome = Outcome::Full;
                                 if (!pair.full) {
                                   collision::PairFrame frame = refinement.frame_of_pair(slice[i].pair);
                                   outcome = refinement.refine_next(slice[i].pair, frame, worker);
                                 }
                                 note_outcome(pair.level.apart, units, outcome,
                                              refinement.levels.tallies[static_cast<std::size_t>(worker)]);
                               }
                             });
      first = end;
    }
    for (const scheduler::Candidate& chosen : round) {
      const PairProgress& pair = all[chosen.pair];
      if (refinement.resources.log != nullptr)
        refinement.resources.log->note_round(chosen.pair, kind_of(pair.full ? Outcome::Full : Outcome::Completed));
      if (!pair.full && pair.refinable()) add(chosen.pair);
    }
  }
}

// No limit, and nobody reads fronts afterwards: each pair to its end, in any order, its front forgotten as soon as it
// is done.
void refine_everything(const Refinement& refinement) {
  const RefineInput& input = refinement.input;
  const PairTable& table = input.table;
  CompletedLevels& levels = refinement.levels;
  DecisionLog* log = refinement.resources.log;
  const bool distant = table.size() > parallel::kPairsAtHand;
  parallel::parallel_for(refinement.executor, table.chunks(), 1, [&](std::size_t chunk, std::size_t, int worker) {
    if (table.known_of_chunk[chunk].refinable == 0) return;
    WorkerTally& tally = levels.tallies[static_cast<std::size_t>(worker)];
    collision::FrontPool& pool = refinement.resources.pools[static_cast<std::size_t>(worker)];
    const std::size_t end = table.end_of(chunk);
    for (std::size_t i = table.begin_of(chunk); i < end; ++i) {
      const std::size_t ahead = i + kPosesAhead;
      if (distant && ahead < end && levels.progress[ahead].refinable())
        prefetch_bodies(input.scene, input.motion, table.pairs[ahead]);
      PairProgress& pair = levels.progress[i];
      if (!pair.refinable()) continue;
      refine_pair(input.refiner(), posed(input.motion, table.pairs[i]), pair, levels.found, refinement.resources.pools,
                  worker, [&](std::uint64_t units, Outcome outcome) {
                    note_outcome(pair.level.apart, units, outcome, tally);
                    if (log != nullptr)
                      log->note(worker, static_cast<std::uint32_t>(i), kind_of(outcome), SteadyClock::now());
                  });
      pool.clear();
      pair.level.front = pair.level.points = {};
    }
  });
}

// Totals of the workers, and what a unit cost.
void sum_tallies(const RefineInput& input, const CompletedLevels& levels, Forecasts& forecasts, FrameReport& report) {
  Nanoseconds busy{0};
  std::uint64_t begun_units = 0;
  for (const WorkerTally& tally : levels.tallies) {
    report.work_refine += tally.units;
    busy += tally.busy;
    begun_units += tally.begun_units;
    report.jobs_done += tally.jobs;
    report.jobs_discarded += tally.discarded;
    report.pairs_separated += tally.separated;
    report.fronts_full += tally.full;
    if (tally.longest > report.longest_job) {
      const ActivePair& pair = input.table.pairs[tally.longest_pair];
      report.longest_job = tally.longest;
      report.longest_job_a = input.scene.bodies.id_of(pair.low());
      report.longest_job_b = input.scene.bodies.id_of(pair.high());
    }
  }
  if (input.step.budget.kind == Budget::Kind::Deadline)
    forecasts.unit_cost.learn(static_cast<double>(busy.count()), begun_units);
}

}  // namespace

RefinementStep::Kind kind_of(Outcome outcome) {
  if (outcome == Outcome::Completed) return RefinementStep::Kind::Completed;
  return outcome == Outcome::Cut ? RefinementStep::Kind::Cut : RefinementStep::Kind::Full;
}

void note_outcome(bool apart, std::uint64_t units, Outcome outcome, WorkerTally& tally) {
  if (outcome == Outcome::Completed) {
    ++tally.jobs;
    tally.units += units;
    if (apart) ++tally.separated;
  } else {
    ++tally.discarded;
    if (outcome == Outcome::Full) ++tally.full;
  }
}

void begin_levels(const PairTable& table, CompletedLevels& levels, parallel::Executor& executor) {
  parallel::reserve_anew(levels.progress, table.capacity());
  parallel::reserve_anew(levels.cues, table.capacity());
  levels.progress.resize(table.size());
  levels.found.begin(table.capacity(), static_cast<std::size_t>(executor.concurrency()));
  levels.cues.resize(table.size());
  levels.known = table.known_of_chunk.back();
  levels.substeps = 0;
  levels.jobs_left = false;
  levels.reused.clear();
  levels.held.clear();
  levels.tallies.assign(static_cast<std::size_t>(executor.concurrency()), WorkerTally{});
  const PairProgress not_begun;  // copied whole: its many numbers one by one take longer
  parallel::parallel_for(executor, table.size(), kCopyGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      levels.progress[i] = not_begun;
      levels.progress[i].begin(table.start[i]);
    }
  });
  for (const SweptPair& swept : table.swept) {
    levels.progress[swept.pair] = swept.progress;
    levels.found.put(levels.progress[swept.pair], swept.contact, 0);
  }
}

std::size_t refine_to_the_end(const RefineInput& input, std::span<collision::FrontPool> pools, CompletedLevels& levels,
                              parallel::Executor& executor) {
  for (collision::FrontPool& pool : pools) pool.clear();
  parallel::Tickets full;
  parallel::parallel_for(executor, input.table.size(), 1, [&](std::size_t begin, std::size_t end, int worker) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!refine_pair(input.refiner(), posed(input.motion, input.table.pairs[i]), levels.progress[i], levels.found,
                       pools, worker)) {
        full.take();
      }
      pools[static_cast<std::size_t>(worker)].clear();
    }
  });
  return full.take(0);
}

void make_points_left(const RefineInput& input, std::span<const collision::FrontPool> pools, CompletedLevels& levels,
                      parallel::Executor& executor) {
  const PairTable& table = input.table;
  parallel::parallel_for(executor, table.chunks(), 1, [&](std::size_t first, std::size_t past, int worker) {
    for (std::size_t chunk = first; chunk < past; ++chunk) {
      if (table.known_of_chunk[chunk].refinable == 0) continue;
      for (std::size_t i = table.begin_of(chunk); i < table.end_of(chunk); ++i) {
        make_points_due(input.refiner(), posed(input.motion, table.pairs[i]), levels.progress[i], levels.found, pools,
                        worker);
      }
    }
  });
}

void make_points_of(std::span<const std::uint32_t> pairs, const RefineInput& input,
                    std::span<const collision::FrontPool> pools, CompletedLevels& levels,
                    parallel::Executor& executor) {
  constexpr std::size_t kPointsGrain = 16;
  parallel::parallel_for(executor, pairs.size(), kPointsGrain, [&](std::size_t begin, std::size_t end, int worker) {
    for (const std::uint32_t index : pairs.subspan(begin, end - begin)) {
      make_points_due(input.refiner(), posed(input.motion, input.table.pairs[index]), levels.progress[index],
                      levels.found, pools, worker);
    }
  });
}

void refine(const RefineInput& given, const RefineResources& resources, CompletedLevels& levels, FrameReport& report,
            parallel::Executor& executor) {
  RefineInput input = given;
  input.learned = &resources.learned;
  input.prepared = &resources.prepared;
  input.points = &resources.points;
  begin_levels(input.table, levels, executor);
  const bool budget_given = input.step.budget.kind != Budget::Kind::Unlimited;
  levels.learns = input.step.replay != nullptr ? input.step.replay->learns
                                               : budget_given && (input.policy.learning > 0 || input.policy.onset != 0);
  if (levels.learns) resources.learned.learn();
  const bool scores = input.step.replay == nullptr ? budget_given : input.step.explain != nullptr;
  resources.prepared.forget();
  if (scores) {
    const SteadyClock::time_point begun = executor.time();
    prepare_cues(input, resources.prepared, executor);
    if (input.step.budget.kind == Budget::Kind::Deadline) report.ranking = executor.time() - begun;
  }
  const Refinement refinement{input, resources, frame_facts(input), levels, executor};
  for (collision::FrontPool& pool : resources.pools) pool.clear();
  if (resources.log != nullptr) {
    // Each level of each pair once, and a pair's last one may have been discarded.
    const std::size_t most = input.table.capacity() * (refinement.facts.deepest_level + std::size_t{1});
    resources.log->begin(input.frame, input.table.size(), resources.pools.size(), most);
    if (levels.learns) resources.log->learns();
  }
  const Budget& budget = input.step.budget;
  if (input.step.replay != nullptr) {
    if (!refine_as_recorded(input, resources.pools, refinement.facts, levels, report, executor))
      report.status = StepStatus::ReplayDiffers;
  } else if (budget.kind == Budget::Kind::Deadline) {
    refine_until_cut(input, resources, refinement.facts, levels, report, executor);
    levels.jobs_left = report.jobs_abandoned > 0;
    if (resources.log != nullptr) log_degraded(levels, report.degraded, *resources.log);
  } else if (budget.kind == Budget::Kind::Unlimited && input.terms.contact != ContactModel::Paper) {
    refine_everything(refinement);
  } else {
    report.cues_refused = fill_all_cues(input, levels, executor);
    refine_by_rounds(refinement,
                     budget.kind == Budget::Kind::Work ? budget.work_units : std::numeric_limits<std::uint64_t>::max());
    make_points_left(input, resources.pools, levels, executor);
  }
  if (levels.learns) observe_gains(input, levels, resources.learned.observed());
  sum_tallies(input, levels, resources.forecasts, report);
}

}  // namespace poise::simulation
