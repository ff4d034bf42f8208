// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "poise/scheduler/policy.h"
#include "poise/types.h"

/// Decisions that a step made by the clock, so that it can be replayed without one (docs/record.md), and the reasons
/// for them.
namespace poise {

/// One action of refinement on a pair.
struct RefinementStep {
  enum class Kind : std::uint8_t {
    Completed,  ///< one more level of the pair completed
    Cut,        ///< a level was begun and discarded because the time was over
    Full,       ///< a level was begun and discarded because its front was full
  };
  std::uint32_t pair = 0;   ///< index among the step's active pairs, which are sorted by their bodies' slots
  std::uint8_t worker = 0;  ///< the worker that did it; 0 with a work budget, where no worker affects the order
  Kind kind = Kind::Completed;
  friend bool operator==(const RefinementStep&, const RefinementStep&) = default;
};

/// Bodies that wait for several steps.
struct PausedIsland {
  std::uint32_t root = 0;   ///< the lowest slot of its bodies
  std::uint32_t steps = 0;  ///< that it leaves out, 1 to 255
  friend bool operator==(const PausedIsland&, const PausedIsland&) = default;
};

/// Everything that a step decided by time (or by counted work). The state after a step depends on the state before it,
/// the calls since, the step's input without its budget, and these decisions. A pair's level is its first level plus
/// its completed steps. The order of the steps and their workers do not affect the state; they are recorded for
/// explanations.
struct FrameDecisions {
  std::uint64_t frame = 0;             ///< number of steps done before this one
  std::uint32_t active_pairs = 0;      ///< of the step; detects decisions of another scene
  std::uint32_t substeps = 0;          ///< of the contact solver; 0: as in the settings
  std::uint32_t point_iterations = 0;  ///< limit of that solver in a substep; 0: its default limit
  /// Of each substep, after how many iterations there was no time for another; 0: it ended by itself. Empty: all did.
  std::vector<std::uint32_t> stopped_after;
  std::uint32_t crowded_partners = 0;  ///< that a body in a crowd kept (Degraded); 0: as in the settings
  bool unfinished = false;             ///< the step goes on in the next frame (StepInput::may_slice): nothing else
  bool learns = false;  ///< with a budget: scores of later steps depend on what completed (Policy::learning, onset)
  std::vector<std::uint32_t> reused;  ///< pairs that reused an expired cached contact, ascending
  std::vector<std::uint32_t> held;    ///< islands that waited, by their lowest slot, ascending
  bool resumed = false;               ///< before the step all paused islands took part again
  std::vector<PausedIsland> paused;   ///< after the step; roots ascending
  std::vector<RefinementStep> steps;  ///< in the order of completion
  friend bool operator==(const FrameDecisions&, const FrameDecisions&) = default;
};

/// Why one level of a pair was refined.
struct LevelExplanation {
  std::uint32_t pair = 0;   ///< as in RefinementStep
  Level level = 0;          ///< the completed level
  std::uint64_t units = 0;  ///< its cost in node-pair expansions
  double score = 0;         ///< scheduler::score when the level was chosen
  bool ended = false;       ///< the level separated the pair
};

/// What became of a pair in a step, and why it was not refined further. Each pair has exactly one.
enum class PairOutcome : std::uint8_t {
  KnownApart,   ///< cached as separated for the whole step; few of these are active (FrameExplanation::pairs_apart)
  KnownPoints,  ///< cached contact points hold, and a deeper level would add nothing
  Mandatory,    ///< of a fast body: refined to its end whatever the budget
  FoundApart,   ///< refined and found separated
  Deepest,      ///< refined to its deepest level
  Reused,       ///< its expired cached contact was used once more, because the step did not fit into its time
  CutOff,       ///< its next level was begun and did not complete in time
  FrontFull,    ///< its next level was begun, and its front did not fit into memory
  Unseen,       ///< what remains of its error is below Policy::seen_threshold_rad
  Unserved,     ///< the budget was used up before its next level had its turn
};

/// Priority and progress of a pair in a step.
struct PairExplanation {
  enum class CacheUse : std::uint8_t {
    None,       ///< nothing cached
    Separated,  ///< cached as separated for the whole step
    Points,     ///< cached contact points
    Expired,    ///< cached contact points that have expired
    Parted,     ///< cached as separated, which has expired
  };
  BodyId a, b;               ///< in the order of slots
  scheduler::PairCues cues;  ///< valid for pairs that could be refined when refinement began
  double weight = 0;         ///< scheduler::cue_weight of the cues
  CacheUse cached = CacheUse::None;
  Level cached_level = 0;  ///< the level of the cached result
  Level level = 0;         ///< completed in this step
  Level deepest = 0;       ///< deepest level of this pair
  bool polygons = false;   ///< the deepest level uses polygons
  bool mandatory = false;  ///< refined to its end whatever the budget: a pair of a fast body, with backtracking
  bool apart = false;      ///< separated in this step
  bool refinable = false;  ///< a further level was left
  PairOutcome outcome = PairOutcome::Unserved;
  std::uint64_t next_units = 0;  ///< cost of the next level, node-pair expansions
  double next_score = 0;         ///< score of the next level
};

/// All priorities of a step, for tuning a policy.
struct FrameExplanation {
  std::uint64_t frame = 0;
  scheduler::Policy policy;
  std::vector<PairExplanation> pairs;  ///< all active pairs, in order
  std::size_t pairs_apart = 0;         ///< near, and known to be apart before: not active, for there is nothing to do
  /// Pair after pair, levels ascending; the order in time is FrameDecisions::steps.
  std::vector<LevelExplanation> levels;
};

}  // namespace poise
