// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "frame/budget/occupied_cells.h"
#include "frame/coarse.h"
#include "frame/refine/found_contacts.h"
#include "frame/refine/refine_level.h"
#include "poise/scheduler/priority_bands.h"
#include "poise/scheduler/rounds.h"
#include "world/decision_log.h"
#include "world/forecasts.h"
#include "world/learned_gains.h"

/// Stage *refine*: deeper levels of the active pairs, best score first, until the budget is spent. The one stage that
/// the deadline cuts (refine_until_cut.cpp).
namespace poise::simulation {

struct OpenRefinement;
struct PreparedCues;

struct RefineInput {
  SceneView scene;
  StepTerms terms;
  const PredictedMotion& motion;
  const PairTable& table;
  const scheduler::Policy& policy;
  StepInput step;  ///< a copy: jobs that are not waited for outlive the caller's
  std::uint64_t frame = 0, seed = 0;
  int substeps = 2;                     ///< of the contact solver, where the frame is not degraded
  std::uint32_t max_front_entries = 0;  ///< capacity of a worker's pool
  SteadyClock::time_point begun{};      ///< when the stage begins
  IslandsWait islands_wait = IslandsWait::Never;
  std::span<const collision::CandidatePair> candidates = {};  ///< of the step, while its stages run
  // Where the step is done in slices, by its own clock.
  SteadyClock::time_point step_begun{};
  Nanoseconds slice{0};  ///< how long each is; else 0
  // Of the stage itself, where scores are asked for.
  const LearnedGains* learned = nullptr;
  const PreparedCues* prepared = nullptr;
  const PointCache* points = nullptr;  ///< of the last step

  [[nodiscard]] PairRefiner refiner() const { return {scene, terms.contact, policy.quantum_units}; }
};

/// What one worker did in a refinement; put together when all have ended. Written after each job.
struct alignas(64) WorkerTally {
  std::uint64_t units = 0;
  std::uint64_t begun_units = 0;  ///< of what took `busy`, completed or not
  std::uint64_t jobs = 0, discarded = 0, separated = 0, full = 0;
  std::uint32_t longest_pair = 0;  ///< in the pair table: of the longest piece
  std::uint32_t longest_units = 0;
  Nanoseconds busy{0}, longest{0}, off_cpu{0}, cpu_before{0};
  Nanoseconds overrun{0}, overrun_off_cpu{0};  ///< largest excess of a piece, and what the system took from it
  SteadyClock::time_point begun{}, ended{}, longest_begun{}, longest_ended{};
};

/// Memory in which the islands of a frame are found (budget/islands.h), and what they hold. Invariant: buffers only
/// grow.
struct IslandSums {
  struct Island {
    std::uint64_t seen = 0;  ///< sum of the weights of its pairs, or bodies
    std::uint32_t bodies = 0, pairs = 0, open = 0, moving = 0, fast = 0, flying = 0, contacts = 0, unknown = 0;
    std::uint32_t restless = 0;
    std::uint32_t angle_urad = 0;  ///< the largest visible angle (radius by distance) of its bodies in view
    bool held = false;
    std::uint8_t steps_paused = 0;  ///< that it leaves out after this one
    void add(const Island& part);   ///< but for the last two; any thread
  };
  parallel::UnsetVector<std::uint32_t> parent;  ///< one a slot: the union-find forest
  OccupiedCells cells;
  parallel::UnsetVector<Island> islands;  ///< one a slot, those of roots are in use
  std::vector<std::uint32_t> sorting;     ///< scratch: roots

  void reserve(std::size_t slot_count) {
    parent.reserve(slot_count);
    islands.reserve(slot_count);
    sorting.reserve(slot_count);
    cells.reserve(slot_count);
  }
};

/// Islands that wait in this frame (budget/hold.h). Invariant: buffers only grow.
struct HeldIslands {
  std::vector<std::uint32_t> roots;   ///< of those that are held: the lowest slot of each, ascending
  std::size_t bodies = 0, pairs = 0;  ///< of these
  std::size_t open = 0;               ///< of these pairs, that have something left to find out before refinement
  parallel::UnsetVector<std::uint8_t> slots;  ///< one a slot, if there are roots: 1 if its body is held

  void clear() {
    roots.clear();
    bodies = pairs = open = 0;
  }
  [[nodiscard]] bool holds(std::size_t slot) const { return !roots.empty() && slots[slot] != 0; }
  void reserve(std::size_t slot_count) {
    roots.reserve(slot_count);
    slots.reserve(slot_count);
  }
};

/// Output of *refine*: how far each pair has come, and what its deepest level found. Invariant: buffers only grow.
struct CompletedLevels {
  parallel::UnsetVector<PairProgress> progress;     ///< one a pair
  FoundContacts found;                              ///< of those with a level beyond 0, and exact ones
  parallel::UnsetVector<scheduler::PairCues> cues;  ///< one a pair: of those that were ranked
  std::vector<WorkerTally> tallies;                 ///< one a worker
  KnownCount known;                    ///< of all pairs before refinement, once it is decided which are reused
  std::int64_t present = 0;            ///< under a deadline: pairs not known to be separated after refinement
  SteadyClock::time_point deadline{};  ///< under one: when the step is to end, with the host's work after it
  parallel::Waits waits;               ///< under a deadline: of the calling thread, for jobs of others
  Nanoseconds off_cpu{0};              ///< under a deadline: what the machine took of that thread meanwhile
  int substeps = 0;                    ///< of the contact solver, where the frame is degraded to fewer; else 0
  bool learns = false;                 ///< FrameDecisions::learns
  bool jobs_left = false;              ///< some that nobody waits for may still read what refinement reads

  HeldIslands held;
  IslandSums islands;                 ///< scratch
  std::vector<std::uint32_t> reused;  ///< pairs that are reused because the frame does not fit (budget/degrade.h)
  parallel::UnsetVector<std::uint8_t> reuse_band;  // scratch: one a pair; 0: it may not be reused
  std::vector<std::size_t> counts;                 // scratch
};

/// What refinement reads and writes of what lasts, and the memory that its workers write fronts into.
struct RefineResources {
  std::span<collision::FrontPool> pools;  ///< one a worker; the paper's model reads its fronts after the stage
  Forecasts& forecasts;
  scheduler::PriorityBands& bands;
  scheduler::RoundSelector& rounds;
  OpenRefinement& open;
  LearnedGains& learned;
  PreparedCues& prepared;
  const PointCache& points;
  DecisionLog* log = nullptr;  ///< of a step that is recorded
};

/// Refines until the budget says stop.
void refine(const RefineInput& input, const RefineResources& resources, CompletedLevels& levels, FrameReport& report,
            parallel::Executor& executor);

/// The end of refinement: the manifold points of the pairs that the budget left before their deepest level. Writes
/// these and nothing else of what was found: workers that are not waited for may still read the rest.
void make_points_left(const RefineInput& input, std::span<const collision::FrontPool> pools, CompletedLevels& levels,
                      parallel::Executor& executor);

/// The same for those of some pairs, each of which is named once, that have points due.
void make_points_of(std::span<const std::uint32_t> pairs, const RefineInput& input,
                    std::span<const collision::FrontPool> pools, CompletedLevels& levels, parallel::Executor& executor);

/// The first thing of the stage: all pairs as *coarse* left them.
void begin_levels(const PairTable& table, CompletedLevels& levels, parallel::Executor& executor);

/// Every active pair to its deepest level, whatever that costs, and its front forgotten: for the reference, which
/// reads no front. After begin_levels. How many pairs had a front that did not fit.
std::size_t refine_to_the_end(const RefineInput& input, std::span<collision::FrontPool> pools, CompletedLevels& levels,
                              parallel::Executor& executor);

/// What a policy may know of the frame.
scheduler::FrameFacts frame_facts(const RefineInput& input);

/// What decides when the next level of an active pair has its turn. `found` is by its completed level, if that is
/// beyond 0.
double score_of(const RefineInput& input, const scheduler::FrameFacts& facts, const scheduler::PairCues& cues,
                const PairProgress& progress, const collision::PairContact& found, std::uint32_t index);

/// How long it takes to make contact points of so many entries (entries_of_points), by all workers together.
inline Nanoseconds time_of_points(double entry_cost_ns, std::int64_t entries) {
  return Nanoseconds(static_cast<std::int64_t>(entry_cost_ns * static_cast<double>(entries)));
}

/// Counts a level that has ended. `apart`: it has found the pair separated.
void note_outcome(bool apart, std::uint64_t units, Outcome outcome, WorkerTally& tally);
RefinementStep::Kind kind_of(Outcome outcome);

/// Under a deadline: in the order of the policy until the time before the reserve is over.
void refine_until_cut(const RefineInput& input, const RefineResources& resources, const scheduler::FrameFacts& facts,
                      CompletedLevels& levels, FrameReport& report, parallel::Executor& executor);

}  // namespace poise::simulation
