// SPDX-License-Identifier: MIT
#include "frame/budget/degrade.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "frame/refine/pair_cues.h"
#include "parallel/disjoint_sets.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"
#include "poise/scheduler/bands.h"

namespace poise::simulation {
namespace {

// How far two bodies may have moved against each other since, in radii of the smaller one: beyond it, what touched is
// elsewhere.
constexpr double kReusePoints = 1.0;
// A pair that was apart must not sink in so far that it cannot be told from one that passes through. Chosen, as
// kHoldOfSize in coarse.cpp.
constexpr double kReuseApart = 0.5;

constexpr std::size_t kChunks = 8;

bool reusable(const RefineInput& input, const PairProgress& progress, std::size_t index) {
  const ActivePair& pair = input.table.pairs[index];
  const CachedPair& cached = *pair.cached;
  // Without a reach nothing was found out, or the caller has moved a body since.
  if (progress.held || progress.cached != CacheUse::None || cached.reach_m <= 0 || !progress.refinable() ||
      progress.exact)
    return false;
  const BodyBounds& a = input.motion.body_bounds[pair.a];
  const BodyBounds& b = input.motion.body_bounds[pair.b];
  const double radius_m = b.plane ? a.radius_m : std::min(a.radius_m, b.radius_m);
  if (cached.apart) return cached.moved_m <= kReuseApart * radius_m;
  // Balls roll, and the normal that they met with rolls along.
  return cached.level > 0 && cached.point_count > 0 && cached.moved_m <= kReusePoints * radius_m;
}

// The band of how little a pair is seen, from 1; and what each band would save.
struct Bands {
  std::array<std::uint32_t, scheduler::kBands + 1> apart{}, points{};
  [[nodiscard]] double saves_ns(std::size_t band, double apart_ns, double points_ns) const {
    return apart[band] * apart_ns + points[band] * points_ns;
  }
};

// Finds levels.reuse_band of all pairs, 0 for those that may not be reused.
Bands find_bands(const RefineInput& input, CompletedLevels& levels, parallel::Executor& executor) {
  const PairTable& table = input.table;
  const PairCueSource cues(input);
  Bands all;
  levels.reuse_band.resize(table.size());
  parallel::for_ranges(executor, {table.chunks(), kChunks}, [&](std::size_t, std::size_t first, std::size_t past) {
    Bands found;
    for (std::size_t chunk = first; chunk < past; ++chunk) {
      for (std::size_t i = table.begin_of(chunk); i < table.end_of(chunk); ++i) {
        levels.reuse_band[i] = 0;
        if (table.known_of_chunk[chunk].outdated == 0 || !reusable(input, levels.progress[i], i)) continue;
        const std::uint32_t band = scheduler::octave_band(cues.seen(static_cast<std::uint32_t>(i)));
        levels.reuse_band[i] = static_cast<std::uint8_t>(std::clamp<std::uint32_t>(band, 1, scheduler::kBands - 1));
        ++(table.pairs[i].cached->apart ? found.apart : found.points)[levels.reuse_band[i]];
      }
    }
    for (std::size_t band = 1; band < found.apart.size(); ++band) {
      parallel::add_shared(all.apart[band], found.apart[band]);
      parallel::add_shared(all.points[band], found.points[band]);
    }
  });
  return all;
}

// True if the pair is separated now.
bool reuse(const ActivePair& pair, PairProgress& progress) {
  progress.cached = pair.cached->apart ? CacheUse::Parted : CacheUse::Expired;
  progress.stop = Stop::Reused;
  return pair.cached->apart;
}

// Adds the first `most` pairs that `chosen` is true of to levels.reused, in canonical order.
template <class Chosen>
void list(std::size_t most, CompletedLevels& levels, parallel::Executor& executor, Chosen&& chosen) {
  constexpr std::size_t kGrain = 4096;
  const std::size_t before = levels.reused.size();
  parallel::select(
      executor, levels.reuse_band.size(), kGrain, levels.counts,
      [&](std::size_t i) { return levels.reuse_band[i] != 0 && chosen(levels.reuse_band[i]); },
      [&](std::size_t count) { levels.reused.resize(before + std::min(count, most)); },
      [&](std::size_t i, std::size_t position) {
        if (position < most) levels.reused[before + position] = static_cast<std::uint32_t>(i);
      });
}

}  // namespace

void use_substeps(const RefineInput& input, int substeps, CompletedLevels& levels) {
  if (substeps > 0 && substeps < input.substeps) levels.substeps = substeps;
}

std::size_t choose_reused(const RefineInput& input, Nanoseconds late, double apart_ns, double points_ns,
                          CompletedLevels& levels, parallel::Executor& executor) {
  levels.reused.clear();
  const Bands bands = find_bands(input, levels, executor);
  auto left_ns = static_cast<double>(late.count());
  std::size_t band = 1;
  while (band < scheduler::kBands && bands.saves_ns(band, apart_ns, points_ns) <= left_ns)
    left_ns -= bands.saves_ns(band++, apart_ns, points_ns);
  constexpr std::size_t kAll = ~std::size_t{0};
  list(kAll, levels, executor, [&](std::size_t of_pair) { return of_pair < band; });
  if (band == scheduler::kBands || left_ns <= 0) return levels.reused.size();
  // Of the last band as many as would do if each saved what they save in the mean.
  const double pairs = static_cast<double>(bands.apart[band]) + static_cast<double>(bands.points[band]);
  const double share = left_ns / bands.saves_ns(band, apart_ns, points_ns);
  list(static_cast<std::size_t>(std::ceil(pairs * share)), levels, executor,
       [&](std::size_t of_pair) { return of_pair == band; });
  return levels.reused.size();
}

void degrade(const RefineInput& input, const Degraded& degraded, CompletedLevels& levels,
             parallel::Executor& executor) {
  constexpr std::size_t kGrain = 1024;
  use_substeps(input, degraded.substeps, levels);
  parallel::Tickets apart;
  parallel::parallel_for(executor, levels.reused.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    std::size_t of_range = 0;
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t pair = levels.reused[k];
      if (reuse(input.table.pairs[pair], levels.progress[pair])) ++of_range;
    }
    apart.take(of_range);
  });
  levels.known.unknown -= static_cast<std::uint32_t>(levels.reused.size());
  levels.known.present -= static_cast<std::uint32_t>(apart.take(0));
}

bool degrade_as_recorded(const RefineInput& input, const FrameDecisions& decisions, CompletedLevels& levels,
                         Degraded& degraded) {
  degraded = {};
  bool there = decisions.substeps < static_cast<std::uint32_t>(input.substeps);
  if (there) degraded.substeps = static_cast<int>(decisions.substeps);
  use_substeps(input, degraded.substeps, levels);
  for (const std::uint32_t index : decisions.reused) {
    if (index >= input.table.size() || !reusable(input, levels.progress[index], index)) {
      there = false;
      continue;
    }
    --levels.known.unknown;
    if (reuse(input.table.pairs[index], levels.progress[index])) --levels.known.present;
    ++degraded.pairs_reused;
  }
  return there;
}

}  // namespace poise::simulation
