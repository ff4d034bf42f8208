// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "frame/broad_phase_stage.h"
#include "frame/pair_progress.h"
#include "frame/predict.h"
#include "parallel/executor.h"
#include "poise/scheduler/host_cue.h"
#include "world/contact_cache.h"

/// Stage *coarse*: the candidates whose root spheres are near each other, and what is cached of them.
namespace poise::simulation {

struct CoarseInput {
  SceneView scene;
  StepTerms terms;
  const PredictedMotion& motion;
  const CandidatePairs& candidates;
  std::span<const CachedPair> cached;  ///< of the last step, sorted by slots; stays as it is during this one
  const PairFilter& filter;
  bool all_active = false;  ///< also what is known to be separated: somebody finds it out anew
};

/// A pair of which something is to be found out or solved in this step.
///
/// A pair is *near* if it is a candidate whose coarsest spheres are nearer than its margin. Of near pairs those are
/// *apart* of which the cache says for sure that they do not touch in this step, which ended before, and whose bodies
/// are not fast: nothing is done about them but that *publish* counts their motion. All others are active.
struct ActivePair {
  std::uint32_t a = 0, b = 0;  ///< slots, a plane always second, a ball first unless both are balls
  double margin_m = 0, skin_m = 0;
  double reach_m = 0;                          ///< what refinement looks for: margin_m and what lets a pair be cached
  const CachedPair* cached = &kNothingCached;  ///< of the last step

  [[nodiscard]] std::uint32_t low() const { return std::min(a, b); }
  [[nodiscard]] std::uint32_t high() const { return std::max(a, b); }
  [[nodiscard]] std::uint64_t id() const { return (std::uint64_t{low()} << 32U) | high(); }
};

/// What is known of some pairs before refinement.
struct KnownCount {
  std::uint32_t begin = 0;        ///< active pairs of all chunks before
  std::uint32_t apart_begin = 0;  ///< likewise those that are apart
  std::uint32_t present = 0;      ///< that are not known to be separated
  std::uint32_t unknown = 0;      ///< of these, that nothing is cached of
  std::uint32_t outdated = 0;     ///< of these, of which what is cached is too old
  std::uint32_t refinable = 0;    ///< at most so many can be refined
  std::uint8_t seen = 0;          ///< the largest CachedPair::seen of those that can be refined
};

/// A candidate that is near, of a chunk of candidates.
struct NearCandidate {
  std::uint32_t cached = 0;    ///< of the cached pairs, or kNone
  std::uint8_t candidate = 0;  ///< of the chunk
  std::uint8_t place = 0;      ///< among the near ones of the chunk
  static constexpr std::uint32_t kNone = 0xffffffffU;
};
static_assert(sizeof(NearCandidate) == 8);

/// Output of *coarse*: the active pairs in canonical order, one entry a pair in each column, and which pairs are apart.
/// Invariant: buffers only grow.
struct PairTable {
  static constexpr std::size_t kMostOfChunk = 128;
  /// Chunks of at most kMostOfChunk near pairs: those of as many candidates, which follow each other.
  [[nodiscard]] std::size_t chunks() const { return known_of_chunk.empty() ? 0 : known_of_chunk.size() - 1; }
  [[nodiscard]] std::size_t begin_of(std::size_t chunk) const { return known_of_chunk[chunk].begin; }
  [[nodiscard]] std::size_t end_of(std::size_t chunk) const { return known_of_chunk[chunk + 1].begin; }
  [[nodiscard]] std::size_t size() const { return pairs.size(); }
  /// Pairs that all columns have room for.
  [[nodiscard]] std::size_t capacity() const { return pairs.capacity(); }

  [[nodiscard]] std::size_t apart_count() const {
    return known_of_chunk.empty() ? 0 : known_of_chunk.back().apart_begin;
  }
  [[nodiscard]] std::size_t apart_count(std::size_t chunk) const {
    return known_of_chunk[chunk + 1].apart_begin - known_of_chunk[chunk].apart_begin;
  }
  /// The k-th of a chunk that are apart, as it is cached.
  [[nodiscard]] const CachedPair& apart(std::size_t chunk, std::size_t k) const {
    return cached[near_apart(chunk, k).cached];
  }
  [[nodiscard]] std::size_t near_count() const { return size() + apart_count(); }
  /// Near pairs of all chunks before.
  [[nodiscard]] std::size_t near_begin(std::size_t chunk) const {
    return std::size_t{known_of_chunk[chunk].begin} + known_of_chunk[chunk].apart_begin;
  }
  /// Of a chunk, the k-th that is active, and the k-th that is apart.
  [[nodiscard]] const NearCandidate& near_active(std::size_t chunk, std::size_t k) const {
    return near[chunk * kMostOfChunk + k];
  }
  [[nodiscard]] const NearCandidate& near_apart(std::size_t chunk, std::size_t k) const {
    return near[(chunk + 1) * kMostOfChunk - 1 - k];
  }
  /// Calls active(i) or apart(cached pair) for all near pairs, in canonical order.
  template <class Active, class Apart>
  void for_each_near(Active&& active, Apart&& apart_pair) const {
    for (std::size_t chunk = 0; chunk < chunks(); ++chunk) {
      const std::size_t begin = begin_of(chunk);
      const std::size_t actives = end_of(chunk) - begin;
      const std::size_t aparts = apart_count(chunk);
      for (std::size_t i = 0, k = 0; i < actives || k < aparts;) {
        if (k == aparts || (i < actives && near_active(chunk, i).place < near_apart(chunk, k).place)) {
          active(begin + i++);
        } else {
          apart_pair(apart(chunk, k++));
        }
      }
    }
  }
  /// Calls use(a, b) for the slots of all near pairs, in parallel.
  template <class Use>
  void for_each_near_bodies(parallel::Executor& executor, Use&& use) const {
    constexpr std::size_t kChunks = 8;
    parallel::parallel_for(executor, chunks(), kChunks, [&](std::size_t first, std::size_t past, int) {
      for (std::size_t chunk = first; chunk < past; ++chunk) {
        for (std::size_t i = begin_of(chunk); i < end_of(chunk); ++i) use(pairs[i].a, pairs[i].b);
        for (std::size_t k = 0; k < apart_count(chunk); ++k) use(apart(chunk, k).low, apart(chunk, k).high);
      }
    });
  }

  parallel::UnsetVector<ActivePair> pairs;
  parallel::UnsetVector<PairStart> start;          ///< where refinement begins
  std::vector<KnownCount> known_of_chunk;          ///< per chunk, and their sums at the end
  std::span<const CachedPair> cached;              ///< with which the step began
  StepTerms terms;                                 ///< of the step
  parallel::UnsetVector<std::uint8_t> still_near;  ///< one a cached pair of the last step: it is near in this one
  std::vector<SweptPair> swept;                    ///< with backtracking: pairs with a fast body, in canonical order

  /// Of each chunk, from where that begins, those that are active; and from its end back those that are apart.
  parallel::UnsetVector<NearCandidate> near;
};

/// A candidate as if it were an active pair, with what is cached of it.
ActivePair near_pair(const StepTerms& terms, const PredictedMotion& motion, const collision::CandidatePair& candidate,
                     const CachedPair& cached);

/// How far a near pair that is apart has come: nowhere.
PairProgress progress_of_apart(const SceneView& scene, const StepTerms& terms, const PredictedMotion& motion,
                               const ActivePair& pair);

/// What the host gave the bodies of an active pair, that of the lower slot first.
scheduler::UserData user_data_of(const SceneView& scene, const ActivePair& pair);

/// What of a pair counts as wide: where no two nodes come within this much more than its reach, it stays separated for
/// that much longer.
double wide_m(const ActivePair& pair);

/// For how many frames that learn (FrameDecisions::learns) a pair has touched, until the last one; 0 if it does not
/// touch.
inline std::uint8_t frames_touched(const ActivePair& pair) {
  constexpr std::uint8_t kMost = 0xff;
  const CachedPair& cached = *pair.cached;
  if (!cached.touching) return 0;
  return cached.frames_touched < kMost ? static_cast<std::uint8_t>(cached.frames_touched + 1) : kMost;
}

/// The estimated separation of a pair that is known by its root spheres alone.
double coarsest_separation_m(const PredictedMotion& motion, const ActivePair& pair);

/// May a pair that stays at level 0 have a contact: is its estimated separation less than its margin? True of a plane.
bool coarsest_near(const PredictedMotion& motion, const ActivePair& pair);

/// `pools`, one a worker, are for backtracking, which refines some pairs at once; they are left empty.
void find_active_pairs(const CoarseInput& input, PairTable& table, std::span<collision::FrontPool> pools,
                       parallel::Executor& executor);

}  // namespace poise::simulation
