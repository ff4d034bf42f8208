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

// Of what is cached, which is `valid` or not.
GainObservation::Life life_of(const CachedPair& cached, bool valid) {
  // It was valid in the frame before if nothing was left to do then.
  if (cached.reach_m == 0 || cached.level == 0 || cached.frames_waited > 0) return GainObservation::Life::Unknown;
  return valid ? GainObservation::Life::Valid : GainObservation::Life::Expired;
}

// What is said of a pair, whatever is known of it.
GainObservation observation_of(const SceneView& scene, std::uint32_t a, std::uint32_t b) {
  GainObservation seen;
  seen.shape_low = std::min(scene.shape_of[a], scene.shape_of[b]);
  seen.shape_high = std::max(scene.shape_of[a], scene.shape_of[b]);
  return seen;
}

// Of the pairs that are apart, every stride-th: what is cached of them holds.
void observe_apart(const RefineInput& input, std::size_t stride, std::vector<GainObservation>& observed) {
  const PairTable& table = input.table;
  std::size_t next = input.frame % stride;
  for (std::size_t chunk = 0; chunk < table.chunks(); ++chunk) {
    for (; next < table.known_of_chunk[chunk + 1].apart_begin; next += stride) {
      const CachedPair& cached = table.apart(chunk, next - table.known_of_chunk[chunk].apart_begin);
      GainObservation seen = observation_of(input.scene, cached.low, cached.high);
      seen.life = life_of(cached, true);
      if (seen.life == GainObservation::Life::Unknown) continue;
      seen.life_level = cached.level;
      seen.hazard =
          static_cast<float>(hazard_by_motion(near_pair(input.terms, input.motion, {cached.low, cached.high}, cached)));
      observed.push_back(seen);
    }
  }
}

}  // namespace

void observe_gains(const RefineInput& input, const CompletedLevels& levels, std::vector<GainObservation>& observed) {
  const std::size_t stride = input.table.near_count() / kMostLookedAt + 1;
  observed.reserve(kMostLookedAt + 2);
  for (std::size_t i = input.frame % stride; i < input.table.size(); i += stride) {
    const ActivePair& pair = input.table.pairs[i];
    const PairProgress& progress = levels.progress[i];
    if (progress.exact) continue;
    const PairStart& start = input.table.start[i];
    GainObservation seen = observation_of(input.scene, pair.a, pair.b);
    seen.level = progress.level.level;
    seen.life = life_of(*pair.cached, start.cached == CacheUse::Separated || start.cached == CacheUse::Points);
    if (seen.level == 0 && seen.life == GainObservation::Life::Unknown) continue;
    if (seen.level > 0) {
      seen.apart = progress.level.apart ? 1 : 0;
      seen.anew = start.cached == CacheUse::None ? 1 : 0;
      if (seen.anew != 0) seen.change_m = change_of(input, levels, i);
    }
    if (seen.life != GainObservation::Life::Unknown) {
      seen.life_level = pair.cached->level;
      seen.hazard = static_cast<float>(hazard_by_motion(pair));
    }
    observed.push_back(seen);
  }
  observe_apart(input, stride, observed);
}

}  // namespace poise::simulation
