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

// Of the time until the cut. Chosen: with all pairs ranked in every frame, a pile of 10,000 whose refinement had 2 ms
// ended late in one frame of ten.
constexpr double kShare = 0.25;

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

bool rank_pairs(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
                SteadyClock::time_point start, SteadyClock::time_point cut, CompletedLevels& levels,
                FrameReport& report, parallel::Executor& executor) {
  const PairTable& table = input.table;
  double& rank_cost_ns = resources.forecasts.rank_cost_ns;
  const double allowed_ns = kShare * static_cast<double>((cut - start).count());
  const auto most = static_cast<std::size_t>(std::max(0.0, allowed_ns / std::max(rank_cost_ns, 1e-3)));
  // Not even the pairs of one chunk.
  if (most * std::max<std::size_t>(table.chunks(), 1) < table.known_of_chunk.back().refinable) return false;
  std::vector<std::uint32_t>& chosen = resources.open.chunks;
  choose_chunks(table, input.frame, most, chosen);
  resources.bands.reset(static_cast<std::uint32_t>(table.size()));
  const PairCueSource source(input);
  parallel::Shared<std::uint64_t> ranked(0);
  parallel::Shared<std::uint64_t> refused(0);
  parallel::parallel_for(executor, chosen.size(), 2, [&](std::size_t first, std::size_t past, int) {
    std::uint64_t put = 0;
    std::uint64_t not_taken = 0;
    // Backwards, because the last one put into a band is the first one taken.
    for (std::size_t k = past; k-- > first;) {
      for (std::size_t i = table.end_of(chosen[k]); i-- > table.begin_of(chosen[k]);) {
        PairProgress& pair = levels.progress[i];
        if (!pair.refinable() || pair.full) continue;
        const auto item = static_cast<std::uint32_t>(i);
        if (!source.fill(item, levels.cues[i])) ++not_taken;
        pair.seen = seen_band(input.policy, levels.cues[i]);
        ++put;
        const double score = score_of(input, facts, levels.cues[i], pair, levels.found[i], item);
        if (!scheduler::left_out(input.policy, score))
          resources.bands.put(item, scheduler::band_of(input.policy, score));
      }
    }
    ranked.add(put);
    refused.add(not_taken);
  });
  report.cues_refused = refused.get();
  const Nanoseconds took = SteadyClock::now() - start;
  report.ranking += took;
  report.pairs_ranked = ranked.get();
  if (ranked.get() >= 100) {
    const double measured_ns = static_cast<double>(took.count()) / static_cast<double>(ranked.get());
    rank_cost_ns += 0.2 * (measured_ns - rank_cost_ns);
  }
  return true;
}

}  // namespace poise::simulation
