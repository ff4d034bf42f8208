// SPDX-License-Identifier: MIT
#pragma once

#include "frame/refine/refine.h"
#include "frame/view_cues.h"
#include "parallel/prefetch.h"

/// What the scores of a frame's pairs are made of. Asked of pairs that are ranked, not of all: in a frame that has no
/// time to refine, cues took as long as finding the pairs.
namespace poise::simulation {

/// The cues of the pairs of one step. Any thread.
class PairCueSource {
 public:
  explicit PairCueSource(const RefineInput& input) : input_(input), view_query_(input.step.view) {}
  /// All cues of a pair, the host's own too. False where the host's gave no number or one out of range.
  bool fill(std::uint32_t index, scheduler::PairCues& cues) const;
  /// Prefetches what fill() reads of a pair that has its turn some pairs later.
  HWY_INLINE void prefetch(std::uint32_t index) const {
    const ActivePair& pair = input_.table.pairs[index];
    for (const std::uint32_t body : {pair.a, pair.b}) {
      parallel::prefetch(input_.motion.poses[body]);
      parallel::prefetch(input_.motion.body_bounds[body]);
      parallel::prefetch(input_.motion.spins_radps[body]);
    }
    if (pair.cached->point_count > 0 && input_.points != nullptr)
      parallel::prefetch(input_.points->points[PointCache::begin(pair.cached->slot)]);
  }
  /// How well an error of the pair is seen now, whatever it has waited and a host thinks of it: a weight, >= 0.
  [[nodiscard]] double seen(std::uint32_t index) const;

 private:
  const RefineInput& input_;
  ViewQuery view_query_;
};

/// Fills levels.cues of all pairs that can be refined; how many cues of the host were refused.
std::size_t fill_all_cues(const RefineInput& input, CompletedLevels& levels, parallel::Executor& executor);

}  // namespace poise::simulation
