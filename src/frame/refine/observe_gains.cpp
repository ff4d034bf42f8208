// SPDX-License-Identifier: MIT
#include "frame/refine/observe_gains.h"

#include <algorithm>
#include <cmath>

#include "frame/refine/learned_chain.h"

namespace poise::simulation {
namespace {

// Chosen: 0.1 ms.
constexpr std::size_t kMostLookedAt = 4096;

// By how much refinement has changed the separation of a pair that began at level 0. What is beyond the margin makes no
// contact, so changes there do not count.
float change_of(const RefineInput& input, const CompletedLevels& levels, std::size_t i) {
  const ActivePair& pair = input.table.pairs[i];
  const double before_m = std::min(coarsest_separation_m(input.motion, pair), pair.margin_m);
  const double found_m =
      levels.progress[i].level.apart
          ? pair.margin_m
          : std::min(levels.found.of(levels.progress[i]).contact.estimated_separation_m, pair.margin_m);
  return static_cast<float>(std::abs(found_m - before_m));
}

GainObservation::Life life_of(const ActivePair& pair, const PairStart& start) {
  const CachedPair& cached = pair.cached;
  // It was valid in the frame before if nothing was left to do then.
  if (cached.reach_m == 0 || cached.level == 0 || cached.frames_waited > 0) return GainObservation::Life::Unknown;
  const bool valid = start.cached == CacheUse::Separated || start.cached == CacheUse::Points;
  return valid ? GainObservation::Life::Valid : GainObservation::Life::Expired;
}

}  // namespace

void observe_gains(const RefineInput& input, const CompletedLevels& levels, std::vector<GainObservation>& observed) {
  const std::size_t stride = input.table.size() / kMostLookedAt + 1;
  observed.reserve(kMostLookedAt + 1);
  for (std::size_t i = input.frame % stride; i < input.table.size(); i += stride) {
    const ActivePair& pair = input.table.pairs[i];
    const PairProgress& progress = levels.progress[i];
    if (progress.exact) continue;
    GainObservation seen;
    seen.level = progress.level.level;
    seen.life = life_of(pair, input.table.start[i]);
    if (seen.level == 0 && seen.life == GainObservation::Life::Unknown) continue;
    const std::uint32_t shape_a = input.scene.shape_of[pair.a];
    const std::uint32_t shape_b = input.scene.shape_of[pair.b];
    seen.shape_low = std::min(shape_a, shape_b);
    seen.shape_high = std::max(shape_a, shape_b);
    if (seen.level > 0) {
      seen.apart = progress.level.apart ? 1 : 0;
      seen.anew = input.table.start[i].cached == CacheUse::None ? 1 : 0;
      if (seen.anew != 0) seen.change_m = change_of(input, levels, i);
    }
    if (seen.life != GainObservation::Life::Unknown) {
      seen.life_level = pair.cached.level;
      seen.hazard = static_cast<float>(hazard_by_motion(pair));
    }
    observed.push_back(seen);
  }
}

}  // namespace poise::simulation
