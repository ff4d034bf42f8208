// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "frame/coarse.h"
#include "world/scene_view.h"

namespace poise::simulation {

// Of how far the bodies may have moved, and of the mean protrusion of a level, this is expected; of what is cached,
// which has been refined further, less. Chosen (docs/priorities.md).
inline constexpr double kExpected = 0.5;
inline constexpr double kExpectedOfCached = 0.2;

inline double protrusion_m(const SceneView& scene, const ActivePair& pair, std::size_t level) {
  return static_cast<double>(scene.facts_of(pair.a).error_m[level] + scene.facts_of(pair.b).error_m[level]);
}

// No error is expected to be smaller.
inline constexpr double kLeastErrorM = 1e-9;

inline double relative_separation(double separation_m, double error_m) {
  return separation_m / std::max(error_m, kLeastErrorM);
}

/// The separation of a pair as far as it is known. What is cached is wrong by what has moved since, what the root
/// spheres say by what they protrude.
struct KnownSeparation {
  bool by_roots = false;    ///< the root spheres know it (coarsest_separation_m), and nobody else
  double separation_m = 0;  ///< otherwise; negative where the surfaces overlap
  double error_m = 0;       ///< that is expected of it
};
inline KnownSeparation known_separation_of(const SceneView& scene, const ActivePair& pair) {
  const CachedPair& cached = *pair.cached;
  if (cached.point_count > 0) {
    return {false, cached.nearest_m,
            kExpected * cached.moved_m + kExpectedOfCached * protrusion_m(scene, pair, cached.level)};
  }
  if (cached.apart && cached.reach_m > 0) return {false, cached.reach_m, kExpected * cached.moved_m};
  return {true, 0, kExpected * protrusion_m(scene, pair, 0)};
}

/// Measures the cue *touch*: that separation over the error that is expected of it.
inline double known_separation(const SceneView& scene, const PredictedMotion& motion, const ActivePair& pair) {
  const KnownSeparation known = known_separation_of(scene, pair);
  return relative_separation(known.by_roots ? coarsest_separation_m(motion, pair) : known.separation_m, known.error_m);
}

/// The same of a pair of which a level has just been completed: by what that has found.
inline double found_separation(const SceneView& scene, const ActivePair& pair, std::size_t level,
                               const collision::PairContact& found) {
  const double separation_m = found.present ? found.estimated_separation_m : pair.margin_m;
  return relative_separation(separation_m, kExpected * protrusion_m(scene, pair, level));
}

}  // namespace poise::simulation
