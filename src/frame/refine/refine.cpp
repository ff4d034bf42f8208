// SPDX-License-Identifier: MIT
#include "frame/refine/refine_level.h"

#include <algorithm>
#include <array>
#include <limits>

#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

// The same for a pair that nobody else looks at.
Outcome complete_own_level(WorldState& world, ActivePair& pair, collision::LevelContact& found, int worker) {
  const Outcome outcome =
      complete_level(world, world.buffers.pools, pair, pair.level, found, worker, [](std::uint64_t) { return true; });
  if (outcome == Outcome::Full) pair.full = true;
  return outcome;
}

// The work clock, and no limit at all: rounds whose members depend on scores and charges alone.
void refine_by_rounds(Refinement& refinement, std::uint64_t budget_units) {
  constexpr std::size_t kRoundGrain = 8;
  WorldState& world = refinement.world;
  FrameBuffers& buffers = world.buffers;
  const auto candidate = [&](std::uint32_t index) {
    const ActivePair& pair = buffers.pairs[index];
    return scheduler::Candidate{score_of(world, refinement.facts, pair, index), index, pair.level.next_units};
  };
  world.rounds.begin_frame(budget_units, buffers.pairs.size(), world.settings.policy.round_pairs);
  for (std::uint32_t i = 0; i < buffers.pairs.size(); ++i) {
    if (buffers.pairs[i].refinable()) world.rounds.add(candidate(i));
  }
  // Whether there is room is decided from worst cases before a round, not by whose pool fills up first: an answer must
  // not depend on threads.
  std::uint64_t room = world.settings.max_front_entries;
  for (;;) {
    const std::span<const scheduler::Candidate> round = world.rounds.next_round();
    if (round.empty()) break;
    // In slices whose worst cases have room.
    for (std::size_t first = 0; first < round.size();) {
      std::uint64_t worst = 0;
      std::size_t end = first;
      for (; end < round.size(); ++end) {
        ActivePair& pair = buffers.pairs[round[end].pair];
        // Polygons make no front.
        const std::uint64_t could_make =
            pair.level.next_is_polygons() ? 0 : std::uint64_t{round[end].units} * kTreeBranching * kTreeBranching;
        if (worst + could_make > room && end > first) break;
        pair.full = worst + could_make > room;
        if (!pair.full) worst += could_make;
      }
      const std::span<const scheduler::Candidate> slice = round.subspan(first, end - first);
      parallel::parallel_for(
          *world.executor, slice.size(), kRoundGrain, [&](std::size_t begin, std::size_t past, int worker) {
            for (std::size_t i = begin; i < past; ++i) {
              ActivePair& pair = buffers.pairs[slice[i].pair];
              const std::uint64_t units = pair.level.next_units;
              const Outcome outcome =
                  pair.full ? Outcome::Full : complete_own_level(world, pair, buffers.found[slice[i].pair], worker);
              note_outcome(pair, units, outcome, refinement.tallies[static_cast<std::size_t>(worker)]);
            }
          });
      for (const scheduler::Candidate& chosen : slice) {
        const ActivePair& pair = buffers.pairs[chosen.pair];
        const bool cached =
            !pair.level.by_polygons() && (pair.level.refinable() || world.settings.contact == ContactModel::Paper);
        if (!pair.full && cached) room -= std::min<std::uint64_t>(room, pair.level.front_entries);
      }
      first = end;
    }
    for (const scheduler::Candidate& chosen : round) {
      const ActivePair& pair = buffers.pairs[chosen.pair];
      if (refinement.log != nullptr)
        refinement.log->note_round(chosen.pair, kind_of(pair.full ? Outcome::Full : Outcome::Completed));
      if (!pair.full && pair.refinable()) world.rounds.add(candidate(chosen.pair));
    }
  }
}

// No limit, and nobody reads fronts afterwards: each pair to its end, in any order, its front forgotten as soon as it
// is done.
void refine_everything(Refinement& refinement) {
  WorldState& world = refinement.world;
  FrameBuffers& buffers = world.buffers;
  parallel::parallel_for(*world.executor, buffers.chunks(), 1, [&](std::size_t chunk, std::size_t, int worker) {
    if (buffers.known_of_chunk[chunk].refinable == 0) return;
    WorkerTally& tally = refinement.tallies[static_cast<std::size_t>(worker)];
    for (std::size_t i = buffers.begin_of(chunk); i < buffers.end_of(chunk); ++i) {
      ActivePair& pair = buffers.pairs[i];
      if (!pair.refinable()) continue;
      while (pair.refinable() && !pair.full) {
        const std::uint64_t units = pair.level.next_units;
        const Outcome outcome = complete_own_level(world, pair, buffers.found[i], worker);
        note_outcome(pair, units, outcome, tally);
        if (refinement.log != nullptr)
          refinement.log->note(worker, static_cast<std::uint32_t>(i), kind_of(outcome), SteadyClock::now());
      }
      buffers.pools[static_cast<std::size_t>(worker)].clear();
      pair.level.front = {};
    }
  });
}

}  // namespace

scheduler::TailWork tail_work(const WorldState& world, std::uint64_t contacts) {
  scheduler::TailWork work = world.times.tail_work;
  work.sphere_contacts = 0;
  work.bodies = world.bodies.dynamic_count();
  work.contacts = contacts;
  work.candidate_pairs = world.buffers.pairs.size();
  if (world.settings.contact == ContactModel::Paper) {
    for (const ActivePair& pair : world.buffers.pairs) {
      if (!pair.apart() && !pair.by_polygons()) work.sphere_contacts += pair.level.front_entries;
    }
  }
  return work;
}

scheduler::FrameFacts frame_facts(const WorldState& world, const StepInput& input) {
  scheduler::FrameFacts facts;
  for (const ShapeFacts& shape : world.shapes) {
    if (shape.shape) facts.deepest_level = std::max<std::uint32_t>(facts.deepest_level, shape.shape->tree.depth());
  }
  if (input.polygons) ++facts.deepest_level;
  facts.frame = world.frame;
  facts.seed = world.settings.seed;
  facts.pairs = static_cast<std::uint32_t>(world.buffers.pairs.size());
  return facts;
}

double score_of(const WorldState& world, const scheduler::FrameFacts& facts, const ActivePair& pair,
                std::uint32_t index) {
  std::array<float, kPolygonBin + 1> error_m{};
  const auto& error_a = world.shapes[world.shape_of[pair.a]].error_m;
  const auto& error_b = world.shapes[world.shape_of[pair.b]].error_m;
  for (std::size_t level = 0; level < error_a.size(); ++level) error_m[level] = error_a[level] + error_b[level];
  // Levels up to the one that is kept bring nothing that is not known.
  for (std::size_t level = 0; pair.cached == CacheUse::Points && level < pair.memory.level; ++level)
    error_m[level] = error_m[pair.memory.level];
  if (pair.level.polygons) error_m[pair.level.deepest] = 0;
  const scheduler::PairChain chain{pair.id(), pair.level.level, std::span(error_m).first(pair.level.deepest + 1U),
                                   pair.level.next_units, user_data_of(world, pair)};
  return scheduler::score(world.settings.policy, facts, chain, world.buffers.cues[index], index);
}

bool refine_level(WorldState& world, ActivePair& pair, collision::LevelContact& found, int worker) {
  return complete_own_level(world, pair, found, worker) == Outcome::Completed;
}

bool refine_pair(WorldState& world, ActivePair& pair, collision::LevelContact& found, int worker) {
  while (pair.refinable() && !pair.full) complete_own_level(world, pair, found, worker);
  return !pair.full;
}

std::size_t refine_to_the_end(WorldState& world) {
  FrameBuffers& buffers = world.buffers;
  for (collision::FrontPool& pool : buffers.pools) pool.clear();
  parallel::Tickets full;
  parallel::parallel_for(*world.executor, buffers.pairs.size(), 1, [&](std::size_t begin, std::size_t end, int worker) {
    collision::FrontPool& pool = buffers.pools[static_cast<std::size_t>(worker)];
    for (std::size_t i = begin; i < end; ++i) {
      ActivePair& pair = buffers.pairs[i];
      if (!refine_pair(world, pair, buffers.found[i], worker)) full.take();
      pool.clear();
    }
  });
  return full.take(0);
}

void refine(WorldState& world, const StepInput& input, FrameReport& report) {
  FrameBuffers& buffers = world.buffers;
  const TimePoint begun = SteadyClock::now();
  std::fill(buffers.tallies.begin(), buffers.tallies.end(), WorkerTally{});
  Refinement refinement{world, input, frame_facts(world, input), buffers.tallies, nullptr};
  for (collision::FrontPool& pool : buffers.pools) pool.clear();
  if (input.record && input.replay == nullptr) refinement.log = &begin_log(world, refinement.facts);
  if (input.replay != nullptr) {
    if (!refine_as_recorded(world, input, refinement.facts, report)) report.status = StepStatus::ReplayDiffers;
  } else if (input.budget.kind == Budget::Kind::Deadline) {
    refine_until_cut(refinement, begun, report);
    if (refinement.log != nullptr) log_degraded(world, report.degraded, *refinement.log);
  } else if (input.budget.kind == Budget::Kind::Unlimited && world.settings.contact != ContactModel::Paper) {
    refine_everything(refinement);
  } else {
    refine_by_rounds(refinement, input.budget.kind == Budget::Kind::Work ? input.budget.work_units
                                                                         : std::numeric_limits<std::uint64_t>::max());
  }
  Nanoseconds busy{0};
  std::uint64_t units = 0;
  for (const WorkerTally& tally : refinement.tallies) {
    units += tally.units;
    busy += tally.busy;
    report.jobs_done += tally.jobs;
    report.jobs_discarded += tally.discarded;
    report.pairs_separated += tally.separated;
    report.fronts_full += tally.full;
    report.longest_job = std::max(report.longest_job, tally.longest);
    report.longest_overrun = std::max(report.longest_overrun, tally.overrun);
  }
  report.work_refine = units;
  if (input.budget.kind == Budget::Kind::Deadline) {
    if (units >= 100) {
      const double measured = static_cast<double>(busy.count()) / static_cast<double>(units);
      world.unit_cost_ns += 0.2 * (measured - world.unit_cost_ns);
    }
  }
  report.times.refine = SteadyClock::now() - begun;
}

}  // namespace poise::simulation
