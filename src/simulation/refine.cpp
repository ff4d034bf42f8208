// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collision/polygon_contact.h"
#include "parallel/shared.h"
#include "simulation/cpu_clock.h"
#include "simulation/decided.h"
#include "simulation/frame_time.h"
#include "simulation/stages.h"

namespace poise::simulation {
namespace {

struct Refinement {
  WorldState& world;
  const StepInput& input;
  scheduler::FrameFacts facts;
  std::span<WorkerTally> tallies;
  DecisionLog* log = nullptr;  // of a step that is recorded
};

enum class Outcome : std::uint8_t { Completed, Cut, Full };

// The polygons of a pair, in bounded pieces, as below.
template <class GoOn>
Outcome complete_polygons(const WorldState& world, std::span<collision::FrontPool> pools, const ActivePair& pair, collision::PairLevel& level,
                          collision::LevelContact& found, GoOn&& go_on) {
  const collision::PairFrame frame = frame_of(world, pair);
  const Mat3 rotation = world.buffers.poses[pair.a].rotation;
  collision::PolygonProgress progress;
  collision::begin_polygons(frame, rotation, level, found, progress);
  std::uint32_t left = level.next_units;
  for (;;) {
    const std::uint32_t units = std::min<std::uint32_t>(left, scheduler::kQuantumUnits);
    if (collision::run_polygons(frame, pools, units, progress) == collision::Quantum::Complete) break;
    left -= units;
    if (!go_on(std::min<std::uint32_t>(left, scheduler::kQuantumUnits))) return Outcome::Cut;
  }
  collision::publish_polygons(frame, rotation, progress, level, found);
  return Outcome::Completed;
}

// One whole level of a pair, in bounded pieces; `go_on(units)` is asked before each piece after the first. What the pair is known by goes on
// in `level` and `found`, which are its own or copies of them; of the pair itself nothing changes.
template <class GoOn>
Outcome complete_level(const WorldState& world, std::span<collision::FrontPool> pools, const ActivePair& pair, collision::PairLevel& level,
                       collision::LevelContact& found, int worker, GoOn&& go_on) {
  if (level.next_is_polygons()) return complete_polygons(world, pools, pair, level, found, go_on);
  collision::PairFrame frame = frame_of(world, pair);
  const Mat3 rotation = world.buffers.poses[pair.a].rotation;
  if (frame.fitted) {
    const std::size_t next = level.level + 1U;
    collision::expect_fits(world.shapes[world.shape_of[pair.a]].deviation_m[next], world.shapes[world.shape_of[pair.b]].deviation_m[next],
                           level.level > 0 ? found.contact.likely_m : 0.0, frame);
  }
  collision::FrontPool& pool = pools[static_cast<std::size_t>(worker)];
  collision::LevelProgress progress = collision::begin_level(level, pool);
  std::uint32_t left = level.front_entries;
  for (;;) {
    const std::uint32_t units = std::min<std::uint32_t>(left, scheduler::kQuantumUnits);
    const collision::Quantum quantum = collision::run_quantum(frame, pools, worker, units, progress);
    if (quantum == collision::Quantum::Complete) break;
    left -= units;
    const bool full = quantum == collision::Quantum::Full;
    if (full || !go_on(std::min<std::uint32_t>(left, scheduler::kQuantumUnits))) {
      pool.release(progress.mark);
      return full ? Outcome::Full : Outcome::Cut;
    }
  }
  collision::publish_level(frame, rotation, pools, progress, level, found);
  if (!level.refinable() && world.settings.contact != ContactModel::Paper) {
    // Nobody reads the front of a pair that is done but the paper's model.
    pool.release(progress.mark);
    level.front = {};
  }
  if (level.next_is_polygons() && level.refinable()) {
    level.next_units = collision::polygon_units(*frame.a, *frame.b, pools, level.front);
  }
  return Outcome::Completed;
}

// The same for a pair that nobody else looks at.
Outcome complete_own_level(WorldState& world, ActivePair& pair, collision::LevelContact& found, int worker) {
  const Outcome outcome = complete_level(world, world.buffers.pools, pair, pair.level, found, worker, [](std::uint64_t) { return true; });
  if (outcome == Outcome::Full) pair.full = true;
  return outcome;
}

RefinementStep::Kind kind_of(Outcome outcome) {
  if (outcome == Outcome::Completed) return RefinementStep::Kind::Completed;
  return outcome == Outcome::Cut ? RefinementStep::Kind::Cut : RefinementStep::Kind::Full;
}

void note_outcome(const ActivePair& pair, std::uint64_t units, Outcome outcome, WorkerTally& tally) {
  if (outcome == Outcome::Completed) {
    ++tally.jobs;
    tally.units += units;
    if (pair.level.apart) ++tally.separated;
  } else {
    ++tally.dropped;
    if (outcome == Outcome::Full) ++tally.full;
  }
}

std::uint64_t answered_of(double share, std::int64_t present) {
  return static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(std::max<std::int64_t>(present, 0))));
}

void put_into_bands(Refinement& refinement) {
  WorldState& world = refinement.world;
  const FrameBuffers& buffers = world.buffers;
  world.bands.reset(static_cast<std::uint32_t>(buffers.pairs.size()));
  parallel::parallel_for(*world.executor, buffers.chunks(), 2, [&](std::size_t first, std::size_t past, int) {
    // Backwards, because the last one put into a band is the first one taken.
    for (std::size_t chunk = past; chunk-- > first;) {
      if (buffers.known_of_chunk[chunk].refinable == 0) continue;
      for (std::size_t i = buffers.end_of(chunk); i-- > buffers.begin_of(chunk);) {
        const ActivePair& pair = buffers.pairs[i];
        if (!pair.refinable()) continue;
        const auto item = static_cast<std::uint32_t>(i);
        world.bands.put(item, scheduler::band_of(world.settings.policy, score_of(world, refinement.facts, pair, item)));
      }
    }
  });
}

void refine_until_cut(Refinement& refinement, TimePoint start, FrameReport& report) {
  // A job that is under way at the cut may take twice its forecast before it is given up. Chosen.
  constexpr Nanoseconds kLeastPatience{100'000};
  WorldState& world = refinement.world;
  const FramePlan plan = plan_frame(world, refinement.input, start, report);
  OpenRefinement& open = world.open;
  open.world = &world;
  open.facts = refinement.facts;
  open.answered_share = world.answered_share;
  open.hands.resize(refinement.tallies.size());
  open.budget = plan.budget;
  open.log = refinement.log;
  open.contacts.set(plan.present);
  open.cut.set(0);
  const scheduler::FrameBudget& budget = open.budget;
  const TimePoint first_cut = budget.cut(plan.expected);
  if (first_cut <= start) return;
  put_into_bands(refinement);
  const Nanoseconds patience = std::max(kLeastPatience, 2 * budget.job_cost(scheduler::kQuantumUnits));
  // A run ends when this thread finds nothing to take; what the others had in hand then may have left another level to do.
  do {
    report.jobs_given_up += world.executor->run_with({first_cut, patience}, open);
  } while (report.jobs_given_up == 0 && open.cut.get() == 0 && !world.bands.empty());
  report.jobs_dropped += report.jobs_given_up;
  const TimePoint end = SteadyClock::now();
  const std::uint64_t left = likely_answered(world, open.contacts.get());
  report.reserve_at_cut = budget.reserve(left);
  report.tail_forecast = budget.tail_forecast(left);
  report.tail_work.contacts = left;
  const TimePoint last_cut = std::max(first_cut, budget.cut(left));
  report.refine_available = last_cut - start;
  report.longest_overrun = std::max(Nanoseconds(0), end - last_cut);
  // While this thread waited for another one's job, the machine may have held that one up.
  const WorkerTally& own = refinement.tallies[0];
  report.waited = own.ended == TimePoint{} ? Nanoseconds(0) : end - own.ended;
  Nanoseconds held_up{0};
  for (std::size_t w = 1; w < refinement.tallies.size(); ++w) {
    held_up = std::max(held_up, refinement.tallies[w].off_cpu);
  }
  if (report.jobs_given_up > 0) held_up = report.waited;
  report.off_cpu = std::min(report.waited, held_up);
}

// The work clock, and no limit at all: rounds whose members depend on scores and charges alone.
void refine_by_rounds(Refinement& refinement, std::uint64_t budget_units) {
  constexpr std::size_t kGrain = 8;
  WorldState& world = refinement.world;
  FrameBuffers& buffers = world.buffers;
  const auto candidate = [&](std::uint32_t index) {
    const ActivePair& pair = buffers.pairs[index];
    return scheduler::Candidate{score_of(world, refinement.facts, pair, index), index, pair.level.next_units};
  };
  world.rounds.begin_frame(budget_units, buffers.pairs.size());
  for (std::uint32_t i = 0; i < buffers.pairs.size(); ++i) {
    if (buffers.pairs[i].refinable()) world.rounds.add(candidate(i));
  }
  // Whether there is room is decided from worst cases before a round, not by whose pool fills up first: an answer must not
  // depend on threads.
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
      parallel::parallel_for(*world.executor, slice.size(), kGrain, [&](std::size_t begin, std::size_t past, int worker) {
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
        const bool kept = !pair.level.by_polygons() && (pair.level.refinable() || world.settings.contact == ContactModel::Paper);
        if (!pair.full && kept) room -= std::min<std::uint64_t>(room, pair.level.front_entries);
      }
      first = end;
    }
    for (const scheduler::Candidate& chosen : round) {
      const ActivePair& pair = buffers.pairs[chosen.pair];
      if (refinement.log != nullptr) refinement.log->note_round(chosen.pair, kind_of(pair.full ? Outcome::Full : Outcome::Completed));
      if (!pair.full && pair.refinable()) world.rounds.add(candidate(chosen.pair));
    }
  }
}

// No limit, and nobody reads fronts afterwards: each pair to its end, in any order, its front forgotten as soon as it is done.
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
        if (refinement.log != nullptr) refinement.log->note(worker, static_cast<std::uint32_t>(i), kind_of(outcome), SteadyClock::now());
      }
      buffers.pools[static_cast<std::size_t>(worker)].clear();
      pair.level.front = {};
    }
  });
}

}  // namespace

bool OpenRefinement::operator()(int worker) {
  // Until commit() this writes what is this worker's own and nothing else.
  const auto w = static_cast<std::size_t>(worker);
  FrameBuffers& buffers = world->buffers;
  WorkerTally tally = buffers.tallies[w];
  TimePoint now = SteadyClock::now();
  if (tally.begun == TimePoint{}) {
    tally.begun = now;
    tally.cpu_before = thread_cpu_time();
  }
  const auto admits = [&](std::uint64_t units) { return budget.admits(now, units, answered_of(answered_share, contacts.get())); };
  const auto end = [&](bool more) {
    tally.ended = now;
    if (!more) tally.off_cpu = std::max(Nanoseconds(0), now - tally.begun - (thread_cpu_time() - tally.cpu_before));
    buffers.tallies[w] = tally;
    return more;
  };
  const std::uint32_t item = world->bands.take();
  std::uint64_t piece_units = 0;
  const bool begins = item != parallel::PriorityBands::kNone &&
                      admits(piece_units = std::min<std::uint64_t>(buffers.pairs[item].level.next_units, scheduler::kQuantumUnits));
  if (!begins) {
    if (!world->executor->commit(worker)) return false;
    if (item != parallel::PriorityBands::kNone) cut.set(1);
    return end(false);
  }
  const ActivePair& pair = buffers.pairs[item];
  collision::PairLevel& level = hands[w].level;
  collision::LevelContact& found = hands[w].found;
  level = pair.level;
  if (level.level > 0) found = buffers.found[item];
  const std::uint64_t units = level.next_units;
  TimePoint piece_begun = now;
  const auto note_piece = [&] {
    now = SteadyClock::now();
    tally.busy += now - piece_begun;
    tally.longest = std::max(tally.longest, now - piece_begun);
    tally.overrun = std::max(tally.overrun, now - piece_begun - budget.job_cost(piece_units));
    piece_begun = now;
  };
  const Outcome outcome = complete_level(*world, buffers.pools, pair, level, found, worker, [&](std::uint64_t next_units) {
    note_piece();
    piece_units = next_units;
    return admits(next_units);
  });
  note_piece();
  if (!world->executor->commit(worker)) return false;
  ActivePair& mine = buffers.pairs[item];
  if (outcome == Outcome::Completed) {
    mine.level = level;
    buffers.found[item] = found;
  }
  if (outcome == Outcome::Full) mine.full = true;
  note_outcome(mine, units, outcome, tally);
  if (log != nullptr) log->note(worker, item, kind_of(outcome), now);
  if (outcome == Outcome::Completed && mine.level.apart) contacts.add(-1);
  if (outcome == Outcome::Completed && mine.refinable()) {
    world->bands.put(item, scheduler::band_of(world->settings.policy, score_of(*world, facts, mine, item)));
  }
  if (outcome == Outcome::Cut) cut.set(1);
  return end(outcome != Outcome::Cut);
}

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
  for (const ShapeFacts& shape : world.shapes) facts.deepest_level = std::max<std::uint32_t>(facts.deepest_level, shape.shape->tree.depth());
  if (input.polygons) ++facts.deepest_level;
  facts.frame = world.frame;
  facts.seed = world.settings.seed;
  facts.pairs = static_cast<std::uint32_t>(world.buffers.pairs.size());
  return facts;
}

double score_of(const WorldState& world, const scheduler::FrameFacts& facts, const ActivePair& pair, std::uint32_t index) {
  std::array<float, kPolygonPlace + 1> error_m{};
  const auto& error_a = world.shapes[world.shape_of[pair.a]].error_m;
  const auto& error_b = world.shapes[world.shape_of[pair.b]].error_m;
  for (std::size_t level = 0; level < error_a.size(); ++level) error_m[level] = error_a[level] + error_b[level];
  // Levels up to the one that is kept bring nothing that is not known.
  for (std::size_t level = 0; pair.kept == Kept::Places && level < pair.memory.level; ++level) error_m[level] = error_m[pair.memory.level];
  if (pair.level.polygons) error_m[pair.level.deepest] = 0;
  const scheduler::PairChain chain{pair.id(), pair.level.level, std::span(error_m).first(pair.level.deepest + 1U),
                                   pair.level.next_units};
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
    if (!refine_as_decided(world, input, refinement.facts, report)) report.status = StepStatus::ReplayDiffers;
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
    report.jobs_dropped += tally.dropped;
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
