// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "poise/scheduler/policy.h"
#include "poise/types.h"

/// Decisions that a step made by the clock, so that it can be replayed without one (docs/record.md), and their reasons.
namespace poise {

/// One thing that refinement did with a pair.
struct RefinementStep {
  enum class Kind : std::uint8_t {
    Completed,  ///< one more level of the pair
    Cut,        ///< a level was begun and discarded: out of time
    Full,       ///< a level was begun and discarded: its front was full
  };
  std::uint32_t pair = 0;   ///< index among the step's active pairs, which are sorted by their bodies' slots
  std::uint8_t worker = 0;  ///< that did it; 0 with a work budget, whose order depends on no worker
  Kind kind = Kind::Completed;
  friend bool operator==(const RefinementStep&, const RefinementStep&) = default;
};

/// Everything that a step decided by time (or by counted work). The state after a step depends on the state before it,
/// the calls since, the step's input less its budget, and this. The level of a pair is the one it began with plus its
/// completed steps; their order and workers change no bit and serve explanations.
struct FrameDecisions {
  std::uint64_t frame = 0;             ///< number of steps done before this one
  std::uint32_t active_pairs = 0;      ///< of the step; detects decisions of another scene
  std::uint32_t substeps = 0;          ///< of the resting-contact solver; 0: those of the settings
  std::uint32_t point_iterations = 0;  ///< limit of that solver in a substep; 0: its own limit
  std::vector<std::uint32_t> reused;   ///< pairs that reused an expired cached contact, ascending
  std::vector<RefinementStep> steps;   ///< in the order in which they ended
  friend bool operator==(const FrameDecisions&, const FrameDecisions&) = default;
};

/// Why one level of a pair was worth its turn.
struct LevelExplanation {
  std::uint32_t pair = 0;   ///< as in RefinementStep
  Level level = 0;          ///< that was completed
  std::uint64_t units = 0;  ///< that it cost, node-pair expansions
  double score = 0;         ///< scheduler::score when it was chosen
  bool ended = false;       ///< it found the pair apart
};

/// What a pair was worth in a step, and how far it got.
struct PairExplanation {
  enum class CacheUse : std::uint8_t {
    None,       ///< nothing cached
    Separated,  ///< cached as separated for all of this step
    Points,     ///< cached contact points
    Expired,    ///< cached contact points that have expired
  };
  BodyId a, b;               ///< in the order of slots
  scheduler::PairCues cues;  ///< only of pairs that could be refined
  double weight = 0;         ///< scheduler::cue_weight of them
  CacheUse cached = CacheUse::None;
  Level cached_level = 0;        ///< that made the cached result
  Level level = 0;               ///< completed in this step
  Level deepest = 0;             ///< that this pair could reach
  bool polygons = false;         ///< the deepest one is that of the polygons
  bool mandatory = false;        ///< refined whole whatever the budget: a fast body's pair, with backtracking
  bool apart = false;            ///< found apart in this step
  bool refinable = false;        ///< a further level was left to do
  std::uint64_t next_units = 0;  ///< that the next level would have cost
  double next_score = 0;         ///< that it had
};

/// A step taken apart for a person who tunes priorities.
struct FrameExplanation {
  std::uint64_t frame = 0;
  scheduler::Policy policy;
  std::vector<PairExplanation> pairs;  ///< all active ones, in order
  std::vector<LevelExplanation>
      levels;  ///< pair after pair, each from its first level on; the order in time is FrameDecisions::steps
};

}  // namespace poise
