// SPDX-License-Identifier: MIT
#include "frame/refine/rank.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "frame/refine/open_refinement.h"
#include "frame/refine/pair_cues.h"
#include "frame/refine/score_lanes.h"
#include "parallel/ranges.h"
#include "poise/scheduler/bands.h"

namespace poise::simulation {
namespace {

// What it takes to give a pair its turn where it had it last, by all workers together; above what is measured. Chosen.
constexpr double kListingNs = 6;
// Of the time for ranking, what may go into that at most. Chosen.
constexpr double kListingShare = 0.5;
// What is expected of ranking a pair falls by this in a frame that has no time for any, but not below the least.
// Chosen.
constexpr double kForgotten = 0.95, kLeastRankCostNs = 30;
// Cues are measured where bodies and points lie, anywhere in memory: prefetched so many pairs ahead.
constexpr std::size_t kAhead = 6;

double seen_radpm(const scheduler::Policy& policy, const scheduler::PairCues& cues) {
  return cues.visibility * (cues.hidden ? policy.hidden_visibility : 1.0) * cues.angle_radpm;
}
std::uint8_t band_of_seen(double radpm) {
  return static_cast<std::uint8_t>(std::clamp<std::uint32_t>(scheduler::octave_band(radpm), 1, scheduler::kBands - 1));
}

// What ranking finds of a pair, once its score is known; `waited`: the bands that it is ahead for having waited.
RankedPair note_score(const scheduler::Policy& policy, double score, double radpm, std::uint32_t waited,
                      PairProgress& pair) {
  RankedPair ranked;
  pair.seen = band_of_seen(radpm);
  ranked.left_out = scheduler::left_out(policy, score);
  ranked.band = scheduler::band_of(policy, score);
  pair.turn = turn_at(ranked.band);
  if (ranked.left_out && pair.stop == Stop::None) pair.stop = Stop::Unseen;
  pair.band = static_cast<std::uint8_t>(std::max(ranked.band, waited + 1) - waited);
  pair.ranked = true;
  return ranked;
}

// Gives the pairs their turns, and finds these of those of some chunks.
class Ranking {
 public:
  Ranking(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
          CompletedLevels& levels)
      : input_(input),
        turns_(resources.open.turns),
        waited_bands_(resources.open.waited_bands),
        facts_(facts),
        levels_(levels),
        source_(input) {
    resources.open.waited_bands.set(input.policy);
  }

  // As many as there is time for until then.
  void rank(std::span<ChunkOfTurns> chunks, SteadyClock::time_point until, parallel::Executor& executor) {
    const bool in_lanes = scores_in_lanes(input_.policy);
    parallel::parallel_for(executor, chunks.size(), 1, [&](std::size_t first, std::size_t past, int) {
      Sums sums;
      LaneScorer scorer(input_);
      for (ChunkOfTurns& chunk : chunks.subspan(first, past - first)) {
        chunk.ranked = executor.time() < until;
        if (!chunk.ranked) continue;
        in_lanes ? rank_in_lanes(chunk, scorer, sums) : rank_one_by_one(chunk, sums);
      }
      ranked_.add(sums.ranked);
      refused_.add(sums.refused);
      band_sum_.add(sums.bands);
    });
  }
  // The others, where they had their turn last; new ones where those that were ranked are in the mean. A job ranks them
  // when it comes to them.
  void list(std::span<const ChunkOfTurns> chunks, parallel::Executor& executor) {
    if (std::ranges::all_of(chunks, &ChunkOfTurns::ranked)) return;
    const std::uint64_t ranked = std::max<std::uint64_t>(ranked_.get(), 1);
    const auto mean = static_cast<std::uint32_t>(band_sum_.get() / ranked);
    parallel::parallel_for(executor, chunks.size(), 16, [&](std::size_t first, std::size_t past, int) {
      for (const ChunkOfTurns& chunk : chunks.subspan(first, past - first)) {
        if (chunk.ranked) continue;
        std::size_t position = chunk.position;
        for (std::size_t i = input_.table.begin_of(chunk.chunk); i < input_.table.end_of(chunk.chunk); ++i) {
          if (!waits(i)) continue;
          const PairProgress& pair = levels_.progress[i];
          const std::uint32_t band = pair.band > 0 ? pair.band + waited_bands_.of(pair) : mean;
          turns_.put(position++, static_cast<std::uint32_t>(i), turn_at(band));
        }
      }
    });
  }
  [[nodiscard]] std::uint64_t ranked() const { return ranked_.get(); }
  [[nodiscard]] std::uint64_t refused() const { return refused_.get(); }

 private:
  struct Sums {
    std::uint64_t ranked = 0, refused = 0, bands = 0;
  };
  [[nodiscard]] bool waits(std::size_t i) const { return levels_.progress[i].refinable() && !levels_.progress[i].full; }
  // Calls use(position, pair) for those that wait.
  template <class Use>
  void for_waiting(const ChunkOfTurns& chunk, Use&& use) {
    const bool distant = input_.table.size() > parallel::kPairsAtHand;
    const std::size_t end = input_.table.end_of(chunk.chunk);
    std::size_t position = chunk.position;
    for (std::size_t i = input_.table.begin_of(chunk.chunk); i < end; ++i) {
      if (distant && i + 2 * kAhead < end) parallel::prefetch(*input_.table.pairs[i + 2 * kAhead].cached);
      if (distant && i + kAhead < end && waits(i + kAhead)) source_.prefetch(static_cast<std::uint32_t>(i + kAhead));
      if (waits(i)) use(position++, static_cast<std::uint32_t>(i));
    }
  }
  void rank_one_by_one(const ChunkOfTurns& chunk, Sums& sums) {
    for_waiting(chunk, [&](std::size_t position, std::uint32_t item) { rank_pair(position, item, sums); });
  }
  void rank_pair(std::size_t position, std::uint32_t item, Sums& sums) {
    PairProgress& pair = levels_.progress[item];
    put(position, item,
        ranked_pair(input_, source_, facts_, item, pair, levels_.found.of(pair).contact, levels_.cues[item]), sums);
  }
  void rank_in_lanes(const ChunkOfTurns& chunk, LaneScorer& scorer, Sums& sums) {
    std::array<std::uint32_t, LaneScorer::kMostPairs> waiting;
    std::array<std::size_t, LaneScorer::kMostPairs> positions;
    std::size_t count = 0;
    for_waiting(chunk, [&](std::size_t position, std::uint32_t item) {
      // One that backtracking has refined is scored by what that found.
      if (levels_.progress[item].level.level > 0) return rank_pair(position, item, sums);
      waiting[count] = item;
      positions[count++] = position;
    });
    if (count == 0) return;
    LaneScorer::Scored scored;
    scorer.score(std::span(waiting).first(count), levels_.progress, scored);
    for (std::size_t k = 0; k < count; ++k) {
      PairProgress& pair = levels_.progress[waiting[k]];
      put(positions[k], waiting[k],
          note_score(input_.policy, scored.score(k), scored.seen_radpm(k), waited_bands_.of(pair), pair), sums);
    }
  }
  void put(std::size_t position, std::uint32_t item, const RankedPair& ranked, Sums& sums) {
    ++sums.ranked;
    sums.refused += ranked.refused ? 1U : 0U;
    sums.bands += ranked.band;
    if (!ranked.left_out) turns_.put(position, item, turn_at(ranked.band));
  }

  const RefineInput& input_;
  TurnOrder& turns_;
  const WaitedBands& waited_bands_;
  const scheduler::FrameFacts& facts_;
  CompletedLevels& levels_;
  PairCueSource source_;
  parallel::Shared<std::uint64_t> ranked_{0}, refused_{0}, band_sum_{0};
};

// Where the pairs of the chunks are put: first those of the chosen ones, and then of the others if these are listed.
// How many there may be.
std::size_t positions_of(const PairTable& table, std::span<const std::uint32_t> chosen, bool lists,
                         std::vector<ChunkOfTurns>& chunks) {
  chunks.clear();
  std::size_t positions = 0;
  const auto add = [&](std::size_t chunk) {
    chunks.push_back({static_cast<std::uint32_t>(chunk), static_cast<std::uint32_t>(positions), false});
    positions += table.known_of_chunk[chunk].refinable;
  };
  for (const std::uint32_t chunk : chosen) add(chunk);
  auto next = chosen.begin();
  for (std::size_t chunk = 0; lists && chunk < table.chunks(); ++chunk) {
    if (next != chosen.end() && *next == chunk) {
      ++next;
    } else if (table.known_of_chunk[chunk].refinable > 0) {
      add(chunk);
    }
  }
  return positions;
}

}  // namespace

std::uint8_t seen_band(const scheduler::Policy& policy, const scheduler::PairCues& cues) {
  return band_of_seen(seen_radpm(policy, cues));
}

void choose_chunks(const PairTable& table, std::uint64_t frame, std::size_t most, std::vector<std::uint32_t>& chosen) {
  chosen.clear();
  const std::size_t chunks = table.chunks();
  std::array<std::uint64_t, scheduler::kBands> pairs_of_band{};
  std::uint64_t all = 0;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    const KnownCount& known = table.known_of_chunk[chunk];
    pairs_of_band[known.seen] += known.refinable;
    all += known.refinable;
  }
  // The bands from `least` on have room in half of what is allowed.
  std::size_t least = scheduler::kBands;
  std::uint64_t best = 0;
  while (all > most && least > 1 && best + pairs_of_band[least - 1] <= most / 2) best += pairs_of_band[--least];
  const std::uint64_t room = std::max<std::uint64_t>(most > best ? most - best : 0, 1);
  const std::uint64_t stride = all > most ? (all - best + room - 1) / room : 1;
  std::uint64_t turn = frame;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    const KnownCount& known = table.known_of_chunk[chunk];
    if (known.refinable == 0) continue;
    if (known.seen >= least || turn++ % stride == 0) chosen.push_back(static_cast<std::uint32_t>(chunk));
  }
}

RankedPair ranked_pair(const RefineInput& input, const PairCueSource& source, const scheduler::FrameFacts& facts,
                       std::uint32_t item, PairProgress& pair, const collision::PairContact& found,
                       scheduler::PairCues& cues) {
  const bool refused = !source.fill(item, cues);
  const double score = score_of(input, facts, cues, pair, found, item);
  RankedPair ranked = note_score(input.policy, score, seen_radpm(input.policy, cues),
                                 scheduler::waited_bands(input.policy, pair.waited), pair);
  ranked.refused = refused;
  return ranked;
}

bool rank_pairs(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
                SteadyClock::time_point start, SteadyClock::time_point cut, CompletedLevels& levels,
                FrameReport& report, parallel::Executor& executor) {
  const PairTable& table = input.table;
  const std::size_t refinable = table.known_of_chunk.back().refinable;
  double& rank_cost_ns = resources.forecasts.rank_cost_ns;
  const double allowed_ns = kRankingShare * static_cast<double>((cut - start).count());
  const double listing_ns = kListingNs * static_cast<double>(refinable);
  // A host's function is called here alone: nobody waits for a job that the system holds up.
  const bool lists = listing_ns < kListingShare * allowed_ns && input.policy.cue.function == nullptr;
  const auto most =
      static_cast<std::size_t>(std::max(0.0, (allowed_ns - (lists ? listing_ns : 0)) / std::max(rank_cost_ns, 1e-3)));
  // Not even the pairs of one chunk. Seldom they are thought to be dearer than they are, and who ranks none does not
  // learn: so they are tried again some time.
  if (most * std::max<std::size_t>(table.chunks(), 1) < refinable) {
    rank_cost_ns = std::max(std::min(rank_cost_ns, kLeastRankCostNs), kForgotten * rank_cost_ns);
    return false;
  }
  OpenRefinement& open = resources.open;
  choose_chunks(table, input.frame, most, open.chunks);
  open.turns.begin(positions_of(table, open.chunks, lists, open.chunks_of_turns));
  const std::span<ChunkOfTurns> chunks = open.chunks_of_turns;
  resources.bands.reset(static_cast<std::uint32_t>(table.size()));
  Ranking ranking(input, resources, facts, levels);
  ranking.rank(chunks.first(open.chunks.size()), start + Nanoseconds(static_cast<std::int64_t>(allowed_ns)), executor);
  const Nanoseconds took = executor.time() - start;
  if (input.policy.cue.function == nullptr) ranking.list(chunks, executor);
  open.turns.make(executor);
  report.ranking += executor.time() - start;
  report.pairs_ranked = ranking.ranked();
  report.cues_refused = ranking.refused();
  if (ranking.ranked() >= 100) {
    const double measured_ns = static_cast<double>(took.count()) / static_cast<double>(ranking.ranked());
    follow(measured_ns, rank_cost_ns);
  }
  return true;
}

}  // namespace poise::simulation
