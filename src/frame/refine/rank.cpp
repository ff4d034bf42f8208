// SPDX-License-Identifier: MIT
#include "frame/refine/rank.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "frame/refine/open_refinement.h"
#include "frame/refine/pair_cues.h"
#include "parallel/ranges.h"
#include "poise/scheduler/bands.h"

namespace poise::simulation {
namespace {

// Of the time until the cut. Chosen: what is not ranked has its turn where it had it last, and is ranked when it comes.
constexpr double kShare = 0.1;
// What it takes to give a pair its turn where it had it last, by all workers together; above what is measured. Chosen.
constexpr double kListingNs = 6;
// Of the time for ranking, what may go into that at most. Chosen.
constexpr double kListingShare = 0.5;
// Cues are measured where bodies and points lie, anywhere in memory: prefetched so many pairs ahead.
constexpr std::size_t kAhead = 6;

// Gives the pairs their turns, and finds these of those of some chunks.
class Ranking {
 public:
  Ranking(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
          CompletedLevels& levels)
      : input_(input), turns_(resources.open.turns), facts_(facts), levels_(levels), source_(input) {}

  void rank(std::span<const ChunkOfTurns> chunks, parallel::Executor& executor) {
    const bool distant = input_.table.size() > parallel::kPairsAtHand;
    parallel::parallel_for(executor, chunks.size(), 1, [&](std::size_t first, std::size_t past, int) {
      Sums sums;
      for (const ChunkOfTurns& chunk : chunks.subspan(first, past - first)) {
        const std::size_t end = input_.table.end_of(chunk.chunk);
        std::size_t position = chunk.position;
        for (std::size_t i = input_.table.begin_of(chunk.chunk); i < end; ++i) {
          if (distant && i + kAhead < end && waits(i + kAhead))
            source_.prefetch(static_cast<std::uint32_t>(i + kAhead));
          if (waits(i)) rank_pair(position++, static_cast<std::uint32_t>(i), sums);
        }
      }
      ranked_.add(sums.ranked);
      refused_.add(sums.refused);
      band_sum_.add(sums.bands);
    });
  }
  // Without ranking them, where they had their turn last; new ones where those that were ranked are in the mean. A job
  // ranks them when it comes to them.
  void list(std::span<const ChunkOfTurns> chunks, parallel::Executor& executor) {
    if (chunks.empty()) return;
    const std::uint64_t ranked = std::max<std::uint64_t>(ranked_.get(), 1);
    const auto mean = static_cast<std::uint32_t>(band_sum_.get() / ranked);
    std::array<std::uint32_t, 256> waited_bands;
    for (std::uint32_t frames = 0; frames < waited_bands.size(); ++frames)
      waited_bands[frames] = scheduler::waited_bands(input_.policy, frames);
    parallel::parallel_for(executor, chunks.size(), 16, [&](std::size_t first, std::size_t past, int) {
      for (const ChunkOfTurns& chunk : chunks.subspan(first, past - first)) {
        std::size_t position = chunk.position;
        for (std::size_t i = input_.table.begin_of(chunk.chunk); i < input_.table.end_of(chunk.chunk); ++i) {
          if (!waits(i)) continue;
          const PairProgress& pair = levels_.progress[i];
          const std::uint32_t band = pair.band > 0 ? pair.band + waited_bands[pair.waited] : mean;
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
  void rank_pair(std::size_t position, std::uint32_t item, Sums& sums) {
    PairProgress& pair = levels_.progress[item];
    const RankedPair ranked =
        ranked_pair(input_, source_, facts_, item, pair, levels_.found.of(pair).contact, levels_.cues[item]);
    ++sums.ranked;
    sums.refused += ranked.refused ? 1U : 0U;
    sums.bands += ranked.band;
    if (!ranked.left_out) turns_.put(position, item, turn_at(ranked.band));
  }

  const RefineInput& input_;
  TurnOrder& turns_;
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
    chunks.push_back({static_cast<std::uint32_t>(chunk), static_cast<std::uint32_t>(positions)});
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
  const double visibility = cues.visibility * (cues.hidden ? policy.hidden_visibility : 1.0);
  const std::uint32_t band = scheduler::octave_band(visibility * cues.angle_radpm);
  return static_cast<std::uint8_t>(std::clamp<std::uint32_t>(band, 1, scheduler::kBands - 1));
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
  RankedPair ranked;
  ranked.refused = !source.fill(item, cues);
  pair.seen = seen_band(input.policy, cues);
  const double score = score_of(input, facts, cues, pair, found, item);
  ranked.left_out = scheduler::left_out(input.policy, score);
  ranked.band = scheduler::band_of(input.policy, score);
  pair.turn = turn_at(ranked.band);
  if (ranked.left_out && pair.stop == Stop::None) pair.stop = Stop::Unseen;
  const std::uint32_t waited = scheduler::waited_bands(input.policy, pair.waited);
  pair.band = static_cast<std::uint8_t>(std::max(ranked.band, waited + 1) - waited);
  pair.ranked = true;
  return ranked;
}

bool rank_pairs(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
                SteadyClock::time_point start, SteadyClock::time_point cut, CompletedLevels& levels,
                FrameReport& report, parallel::Executor& executor) {
  const PairTable& table = input.table;
  const std::size_t refinable = table.known_of_chunk.back().refinable;
  double& rank_cost_ns = resources.forecasts.rank_cost_ns;
  const double allowed_ns = kShare * static_cast<double>((cut - start).count());
  const double listing_ns = kListingNs * static_cast<double>(refinable);
  // A host's function is called here alone: nobody waits for a job that the system holds up.
  const bool lists = listing_ns < kListingShare * allowed_ns && input.policy.cue.function == nullptr;
  const auto most =
      static_cast<std::size_t>(std::max(0.0, (allowed_ns - (lists ? listing_ns : 0)) / std::max(rank_cost_ns, 1e-3)));
  // Not even the pairs of one chunk.
  if (most * std::max<std::size_t>(table.chunks(), 1) < refinable) return false;
  OpenRefinement& open = resources.open;
  choose_chunks(table, input.frame, most, open.chunks);
  open.turns.begin(positions_of(table, open.chunks, lists, open.chunks_of_turns));
  const std::span<const ChunkOfTurns> chunks = open.chunks_of_turns;
  resources.bands.reset(static_cast<std::uint32_t>(table.size()));
  Ranking ranking(input, resources, facts, levels);
  ranking.rank(chunks.first(open.chunks.size()), executor);
  const Nanoseconds took = executor.time() - start;
  ranking.list(chunks.subspan(open.chunks.size()), executor);
  open.turns.make(executor);
  report.ranking += executor.time() - start;
  report.pairs_ranked = ranking.ranked();
  report.cues_refused = ranking.refused();
  if (ranking.ranked() >= 100) {
    const double measured_ns = static_cast<double>(took.count()) / static_cast<double>(ranking.ranked());
    rank_cost_ns += 0.2 * (measured_ns - rank_cost_ns);
  }
  return true;
}

}  // namespace poise::simulation
