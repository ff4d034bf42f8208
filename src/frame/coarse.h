// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "frame/broad_phase_stage.h"
#include "frame/pair_progress.h"
#include "frame/predict.h"
#include "poise/scheduler/host_cue.h"
#include "world/contact_cache.h"

/// Stage *coarse*: the candidates whose root spheres are near each other, and what is cached of them.
namespace poise::simulation {

struct CoarseInput {
  SceneView scene;
  StepTerms terms;
  const PredictedMotion& motion;
  const CandidatePairs& candidates;
  std::span<const CachedPair> cached;  ///< of the last step, sorted by slots
  const PairFilter& filter;
};

/// A candidate pair whose coarsest spheres are nearer than its margin.
struct ActivePair {
  std::uint32_t a = 0, b = 0;  ///< slots, a plane always second
  double margin_m = 0, skin_m = 0;
  double reach_m = 0;  ///< what refinement looks for: margin_m and what lets a pair be cached
  CachedPair cached;

  [[nodiscard]] std::uint32_t low() const { return std::min(a, b); }
  [[nodiscard]] std::uint32_t high() const { return std::max(a, b); }
  [[nodiscard]] std::uint64_t id() const { return (std::uint64_t{low()} << 32U) | high(); }
};

/// What is known of some pairs before refinement.
struct KnownCount {
  std::uint32_t begin = 0;         ///< pairs of all chunks before
  std::uint32_t present = 0;       ///< that are not known to be separated
  std::uint32_t unknown = 0;       ///< of these, that nothing is cached of
  std::uint32_t outdated = 0;      ///< of these, of which what is cached is too old
  std::uint32_t refinable = 0;     ///< at most so many can be refined
  std::uint32_t without_slot = 0;  ///< at most so many have no slot in the point cache and may need one
  std::uint8_t seen = 0;           ///< the largest CachedPair::seen of those that can be refined
};

/// Output of *coarse*: the active pairs in canonical order, one entry a pair in each column. Invariant: buffers only
/// grow.
struct PairTable {
  static constexpr std::size_t kMostOfChunk = 128;
  /// Chunks of at most kMostOfChunk pairs: those of a chunk of candidates follow each other.
  [[nodiscard]] std::size_t chunks() const { return known_of_chunk.empty() ? 0 : known_of_chunk.size() - 1; }
  [[nodiscard]] std::size_t begin_of(std::size_t chunk) const { return known_of_chunk[chunk].begin; }
  [[nodiscard]] std::size_t end_of(std::size_t chunk) const { return known_of_chunk[chunk + 1].begin; }
  [[nodiscard]] std::size_t size() const { return pairs.size(); }
  /// Pairs that all columns have room for.
  [[nodiscard]] std::size_t capacity() const { return pairs.capacity(); }

  parallel::UnsetVector<ActivePair> pairs;
  parallel::UnsetVector<PairStart> start;            ///< where refinement begins
  std::vector<KnownCount> known_of_chunk;            ///< per chunk, and their sums at the end
  parallel::UnsetVector<std::uint8_t> still_active;  ///< one a cached pair of the last step: it is active in this one
  std::vector<SweptPair> swept;                      ///< with backtracking: pairs with a fast body, in canonical order

  parallel::UnsetVector<std::uint32_t> near;  // scratch: those of each chunk of candidates, from where that begins
};

/// What the host gave the bodies of an active pair, that of the lower slot first.
scheduler::UserData user_data_of(const SceneView& scene, const ActivePair& pair);

/// What of a pair counts as wide: where no two nodes come within this much more than its reach, it stays separated for
/// that much longer.
double wide_m(const ActivePair& pair);

/// For how many frames that learn (FrameDecisions::learns) a pair has touched, until the last one; 0 if it does not
/// touch.
inline std::uint8_t frames_touched(const ActivePair& pair) {
  constexpr std::uint8_t kMost = 0xff;
  if (!pair.cached.touching) return 0;
  return pair.cached.frames_touched < kMost ? static_cast<std::uint8_t>(pair.cached.frames_touched + 1) : kMost;
}

/// The estimated separation of a pair that is known by its root spheres alone.
double coarsest_separation_m(const PredictedMotion& motion, const ActivePair& pair);

/// May a pair that stays at level 0 have a contact: is its estimated separation less than its margin? True of a plane.
bool coarsest_near(const PredictedMotion& motion, const ActivePair& pair);

/// `pools`, one a worker, are for backtracking, which refines some pairs at once; they are left empty.
void find_active_pairs(const CoarseInput& input, PairTable& table, std::span<collision::FrontPool> pools,
                       parallel::Executor& executor);

}  // namespace poise::simulation
