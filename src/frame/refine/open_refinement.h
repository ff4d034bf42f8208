// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "frame/refine/pair_cues.h"
#include "frame/refine/refine.h"
#include "frame/refine/turn_order.h"
#include "parallel/shared_counters.h"
#include "poise/scheduler/frame_budget.h"
#include "poise/scheduler/policy.h"

namespace poise::simulation {

/// A step of refinement that a job has made, for the log.
struct RefinementNote {
  std::uint32_t item;
  RefinementStep::Kind kind;
  SteadyClock::time_point when;
};

/// A chunk of the pair table, and where the first of its pairs is put into the order of turns.
struct ChunkOfTurns {
  std::uint32_t chunk = 0, position = 0;
  bool ranked = false;  ///< else they have their turn where they had it last
};

/// By how many bands pairs are ahead for having waited (scheduler::waited_bands), by PairProgress::waited. Logarithms
/// that are the same in all frames of a policy.
class WaitedBands {
 public:
  void set(const scheduler::Policy& policy) {
    if (policy.kind == kind_ && policy.waiting == weight_) return;
    kind_ = policy.kind;
    weight_ = policy.waiting;
    for (std::uint32_t frames = 0; frames < bands_.size(); ++frames)
      bands_[frames] = scheduler::waited_bands(policy, frames);
  }
  [[nodiscard]] std::uint32_t of(const PairProgress& pair) const { return bands_[pair.waited]; }

 private:
  scheduler::PolicyKind kind_{};
  double weight_ = -1;  // none
  std::array<std::uint32_t, 256> bands_{};
};

/// What the workers of a refinement under a deadline read and write before they publish a level. It belongs to the
/// World, not to the frame: a worker that the system holds up in the middle of a job is not waited for
/// (parallel::Executor::run_with), and may still read this, the outputs of *predict* and *coarse*, the shapes and the
/// fronts when the solver has long begun. It settles before the next step.
struct OpenRefinement {
  /// One job of one worker: some of the best pairs that there are, if the forecast lets them begin. False: nothing more
  /// for this worker.
  bool operator()(int worker);
  class Job;

  /// One refinement: all that it reads, and what it publishes into.
  struct Run {
    RefineInput input;
    std::span<collision::FrontPool> pools;
    scheduler::PriorityBands& bands;
    CompletedLevels& levels;
    parallel::Executor& executor;
    scheduler::FrameFacts facts;
    scheduler::FrameBudget budget;
    double solved_share = 1;   ///< of the pairs not found separated
    std::uint32_t block = 1;   ///< pairs that a worker takes of the order of turns at once
    double entry_cost_ns = 0;  ///< of making contact points, an entry (entries_of_points), by all workers together
    bool cues_kept = true;     ///< CompletedLevels::cues has those of pairs that were ranked; else they are found again
    DecisionLog* log = nullptr;  ///< of a step that is recorded
  };
  /// What a job has found out of one pair.
  struct Hand {
    std::uint32_t item = scheduler::PriorityBands::kNone;  ///< in the pair table
    PairProgress progress;
    collision::LevelContact found;
    PassedLevel passed;                  ///< while found.gaps_only
    Outcome ended = Outcome::Completed;  ///< of the last level
    bool newly_ranked = false;           ///< by this job
    bool has_cues = false;               ///< `cues` are those of the pair
    scheduler::PairCues cues;
    bool completed = false;        ///< at least one level
    bool again = false;            ///< the next level has its turn later, in this band
    std::uint32_t due_before = 0;  ///< entries of its contact points that were due before
    std::uint32_t band = 0;
  };
  /// What one worker holds: the pairs of its job, which become everybody's when the job commits.
  struct alignas(64) Batch {
    static constexpr std::size_t kMost = 16;  ///< chosen: with what goes with them they fit a first-level cache
    std::array<Hand, kMost> hands;
    std::size_t count = 0;
    collision::LevelContact before;  ///< of a level that may be cut: what was known until then
    /// What is left of the worker's chunk of pairs, or of its block of places in the order of turns.
    std::uint32_t next = 0, past = 0;
    bool looks = false;                 ///< of a chunk: how well they are seen is found out again
    std::vector<RefinementNote> notes;  ///< of a step that is recorded
    std::vector<std::uint32_t> due;     ///< pairs that this worker's jobs left with contact points due

    /// For all that one job can note, and of so many pairs.
    void reserve(std::size_t pairs) {
      notes.reserve(kMost * (kPolygonBin + 2));
      due.reserve(pairs);
    }
  };
  std::optional<Run> run;
  std::optional<PairCueSource> cues;                ///< of the run
  parallel::Shared<std::int64_t> contacts{0};       ///< pairs not found separated
  parallel::Shared<std::int64_t> ended{0};          ///< pairs that have come as deep as they go
  parallel::Shared<std::int64_t> due{0};            ///< entries that contact points are to be made of when all is over
  parallel::Shared<int> cut{0};                     ///< not 0: the time is up for a job that was next
  std::optional<parallel::Shares> chunks_in_order;  ///< there: pairs go as they stand, whatever their score
  SteadyClock::time_point in_order_until{};         ///< but no longer than this
  TurnOrder turns;                                  ///< of those that are ranked
  WaitedBands waited_bands;                         ///< of the run
  std::vector<Batch> batches;                       ///< one a worker
  std::vector<std::uint32_t> chunks;                // scratch: of pairs that are ranked
  std::vector<std::uint32_t> due_pairs;             // scratch: of all workers
  std::vector<ChunkOfTurns> chunks_of_turns;        // scratch
};

}  // namespace poise::simulation
