// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/front/pair_refinement.h"
#include "collision/triangles/true_surface.h"
#include "dynamics/body_store.h"
#include "frame/ccd/swept_state.h"
#include "frame/refine/decision_log.h"
#include "frame/refine/open_refinement.h"
#include "parallel/built_once.h"
#include "parallel/executor.h"
#include "parallel/large_pages.h"
#include "poise/scheduler/forecast.h"
#include "poise/scheduler/frame_budget.h"
#include "poise/scheduler/policy.h"
#include "poise/scheduler/priority_bands.h"
#include "poise/scheduler/rounds.h"
#include "poise/world.h"
#include "query/body_index.h"
#include "solver/contact_solver.h"
#include "solver/impact_row.h"
#include "solver/solver.h"
#include "world/candidate_cache.h"
#include "world/contact_cache.h"

namespace poise::simulation {

/// What is known of a shape before any step.
struct ShapeFacts {
  ShapePtr shape;
  std::array<float, kMaxTreeDepth + 1>
      error_m{};  ///< area-weighted mean protrusion of each level; the last one repeats
  std::array<double, kMaxTreeDepth + 1>
      deviation_m{};          ///< of the surface from the fits of each level, the mean over its nodes; likewise
  double least_extent_m = 0;  ///< collision::least_extent_m
};

/// What a pair takes from one frame to the next. Part of the state.
///
/// What was once found out about a pair counts for as long as its bodies have not moved too far against each other:
/// that it is apart, or the places where it may touch. Invariant: the first of its places answers impacts, the others
/// (or the first, if it is alone) rest.
struct CachedPair {
  std::uint32_t low = 0, high = 0;  ///< slots
  std::uint32_t frames_waited = 0;  ///< since a level beyond the mandatory one was completed
  std::uint32_t room = kNoSlot;     ///< of its places in WorldState::places; which one is not part of the state
  std::uint8_t point_count = 0;
  Level level = 0;  ///< that found it out
  bool touching = false;
  bool apart = false;   ///< nothing was nearer than reach_m
  bool solved = false;  ///< in the last step: its places may bear something
  double reach_m = 0;   ///< all that was nearer than this is in the places; 0: nothing is kept but impulses
  double moved_m = 0;   ///< at most by so much has any gap changed since
  double nearest_m = 0,
         impact_gap_m = 0;  ///< least gap of its places, and that of the first, when these were last looked at
  double looked_m = 0;      ///< moved_m at that time
  /// By how much a gap may have changed since the last look: normals turn with the bodies, so by a little more than the
  /// surfaces have moved.
  [[nodiscard]] double changed_m() const { return 2.0 * (moved_m - looked_m); }
};

/// What of a pair's memory counts in a frame.
enum class CacheUse : std::uint8_t {
  None,
  Separated,  ///< it cannot touch in this step
  Points,     ///< it can touch at its places only
  Expired,    ///< its places are too old to be sure of, and better than nothing
};

/// A candidate pair whose coarsest spheres are nearer than its margin, during one frame. Small: every stage goes
/// through all of them. What refinement found of it and what a viewer sees of it are in FrameBuffers::found and cues.
struct alignas(64) ActivePair {
  std::uint32_t a = 0, b = 0;  ///< slots, a plane always second
  double margin_m = 0, skin_m = 0;
  double reach_m = 0;  ///< what refinement looks for: margin_m and what lets a pair keep what it finds
  CacheUse cached = CacheUse::None;
  bool full = false;             ///< a front had no room: left at its level
  std::uint8_t point_count = 0;  ///< of this frame
  bool solved = false;           ///< a place is nearer than the margin
  bool exact = false;            ///< its contact is there whatever its level: a pair of backtracking
  CachedPair memory;             ///< its room is that of this frame's places too
  collision::PairLevel level;    ///< what refinement knows; the contact of level 0 is made only if the pair stays there

  [[nodiscard]] std::uint32_t low() const { return std::min(a, b); }
  [[nodiscard]] std::uint32_t high() const { return std::max(a, b); }
  [[nodiscard]] std::uint64_t id() const { return (std::uint64_t{low()} << 32U) | high(); }
  /// Refinement found out more than what is kept.
  [[nodiscard]] bool fresh() const {
    return level.level > 0 &&
           ((cached != CacheUse::Points && cached != CacheUse::Expired) || level.apart || level.level >= memory.level);
  }
  [[nodiscard]] bool from_cache() const {
    return (cached == CacheUse::Points || cached == CacheUse::Expired) && !fresh();
  }
  [[nodiscard]] bool apart() const { return cached == CacheUse::Separated || level.apart; }
  [[nodiscard]] Level solved_level() const { return from_cache() ? memory.level : level.level; }
  [[nodiscard]] bool by_polygons() const { return level.polygons && solved_level() == level.deepest; }
  [[nodiscard]] bool refinable() const {
    return level.refinable() && cached != CacheUse::Separated &&
           !(cached == CacheUse::Points && memory.level >= level.deepest);
  }
};

// Two cache lines: all stages of a frame go through all pairs.
static_assert(sizeof(ActivePair) == 128);

/// How a body moved in a step.
struct StepMotion {
  Vec3 moved_m = Vec3::Zero();
  double turned_m = 0;  ///< at most by so much its surface moved by turning
};

/// What one worker did in a refinement; put together when all have ended.
struct WorkerTally {
  std::uint64_t units = 0;
  std::uint64_t jobs = 0, discarded = 0, separated = 0, full = 0;
  Nanoseconds busy{0}, longest{0}, overrun{0}, off_cpu{0}, cpu_before{0};
  SteadyClock::time_point begun{}, ended{};
};

/// What finding pairs looks at of a body, side by side: two cache lines.
struct alignas(64) BodyBounds {
  Vec3 position_m = Vec3::Zero();  ///< of a plane: its normal
  double bound_m = 0;  ///< of a ball that holds the body wherever it may be during the step; of a plane: its height
  Vec3 root_center_m = Vec3::Zero();  ///< of the root sphere
  double root_radius_m = 0;
  Vec3 velocity_mps = Vec3::Zero();
  double estimated_radius_m =
      0;             ///< of the ball about the root's centre whose surface is likely that of the body; may be negative
  double own_m = 0;  ///< by how much its surface may move beyond what velocity and gravity do
  double radius_m = 0;
  bool plane = false, dynamic = false;
  bool meshed = false;  ///< its shape has a surface of polygons
  Level depth = 0;      ///< of its tree; 0 of a plane
};
static_assert(sizeof(BodyBounds) == 128);

/// A candidate: slots, and how much the gap of the two bodies may close in the step by their own motion.
struct PairRecord {
  std::uint32_t candidate = 0;
  std::uint32_t a = 0, b = 0;  ///< a plane always second
  double margin_m = 0, skin_m = 0;
};

/// What is known of some pairs before refinement.
struct KnownCount {
  std::uint32_t begin = 0;         ///< pairs of all chunks before
  std::uint32_t present = 0;       ///< that are not known to be apart
  std::uint32_t unknown = 0;       ///< of these, that nothing is kept of
  std::uint32_t outdated = 0;      ///< of these, of which something was found out that is too old
  std::uint32_t refinable = 0;     ///< at most so many can be refined
  std::uint32_t without_slot = 0;  ///< at most so many have no room for places and may need one
  std::uint32_t refused_cues = 0;  ///< for which the host's cue gave no number or one out of range
};

/// What there is to answer among some pairs.
struct SolvedCount {
  std::uint32_t before = 0;  ///< answered pairs of all chunks before
  bool any_fast = false;     ///< one of them may have an impact
  std::uint32_t solved = 0, left = 0, cached_separations = 0, cached_contacts = 0;
  std::uint32_t manifold_points = 0;  ///< of the answered ones
  std::uint32_t new_slots = 0;
  std::array<std::uint32_t, kPolygonBin + 1> levels{};
};

/// Everything that one step works on. Invariant: buffers only grow.
struct FrameBuffers {
  /// Chunks of pairs: those of a chunk of candidates follow each other.
  [[nodiscard]] std::size_t chunks() const { return known_of_chunk.empty() ? 0 : known_of_chunk.size() - 1; }
  [[nodiscard]] std::size_t begin_of(std::size_t chunk) const { return known_of_chunk[chunk].begin; }
  [[nodiscard]] std::size_t end_of(std::size_t chunk) const { return known_of_chunk[chunk + 1].begin; }

  parallel::LargeVector<collision::Pose> poses;   // one a slot
  parallel::LargeVector<BodyBounds> body_bounds;  // one a slot
  parallel::LargeVector<Mat3> inverse_inertia;    // one a slot, world frame
  std::vector<collision::MotionBound> bounds;
  std::vector<collision::PlaneBound> planes;
  std::vector<KnownCount> known_of_chunk;                // per chunk of candidates, and their sums
  parallel::LargeVector<PairRecord> pair_records;        // of candidates that are active, chunk after chunk
  parallel::LargeVector<ActivePair> pairs;               // in canonical order
  parallel::LargeVector<collision::LevelContact> found;  // one a pair: of those that were refined in this frame
  parallel::LargeVector<scheduler::PairCues> cues;       // one a pair: of those that can be refined
  std::vector<std::uint8_t> recalled;                    // one a pair of the last frame: it is one of this frame's too
  std::vector<std::uint8_t> turned;                      // one a pair: its touch began or ended
  parallel::LargeVector<Vec3> touch_ns;      // one a pair: what an event of its touch tells, if there is one
  std::vector<collision::FrontPool> pools;   // one a worker
  std::vector<WorkerTally> tallies;          // one a worker
  std::vector<SolvedCount> solved_of_chunk;  // per chunk of candidates, as known_of_chunk
  parallel::LargeVector<solver::Manifold>
      manifolds_of_chunk;  // those that are answered, chunk after chunk from where its pairs begin
  parallel::LargeVector<solver::Manifold> manifolds;  // the same one after another, in canonical order
  std::uint64_t manifold_points = 0;                  // of these
  std::vector<solver::Coloring::Edge> edges;          // of these
  parallel::LargeVector<Vec3> applied_impulse_ns;     // to these: what b received from rest
  solver::Coloring coloring;
  solver::SolveScratch scratch;
  bool impacts = false;  // some pair may have one: scratch.gates and rows are of this frame
  parallel::LargeVector<solver::ContactRow>
      rows;                         // in the order of the colouring; those whose gate is ready hold something
  std::vector<StepMotion> motions;  // one a slot, of the step that ends
  std::vector<solver::PointContact> points;
  std::vector<std::uint32_t> points_begin;                  // per answered pair; only the paper's model has any
  parallel::LargeVector<solver::SolverBody> solver_bodies;  // one a slot
  std::vector<solver::Acceleration> accelerations;          // one a slot
  SweptFrame swept;
  struct LeastSeen {
    double weight = 0;
    std::uint32_t pair = 0;
    double saves_ns = 0;
  };
  std::vector<LeastSeen> least_seen;  // pairs that may answer as they did last
};

/// What impacts did to the k-th row in the order of the colouring; null where there was none to look for.
inline const solver::ContactRow* row_of(const FrameBuffers& buffers, std::size_t k) {
  return buffers.impacts && buffers.scratch.activations[k].ready ? &buffers.rows[k] : nullptr;
}

/// What the reference of a frame works on (simulation/reference.h). A World that never asks for one has none.
struct Reference {
  static constexpr std::size_t kColumns = 19;
  std::array<std::vector<double>, kColumns> columns;  ///< of the bodies at the start of the frame
  std::vector<std::uint8_t> pushed;
  FrameBuffers frame;   ///< the reference's own; the run's while the reference is made
  ContactCache points;  ///< of the start of the frame; the run's while the reference is made
  std::vector<std::unique_ptr<collision::TrueSurface>> surfaces;  ///< one a shape, made when it is first asked for
};

/// What sleeping needs (simulation/sleep.h). Empty in a World that does without. Part of the state but for what is only
/// scratch.
struct Sleep {
  std::vector<double> still_s;  ///< one a slot: for how long an awake body has been still
  std::vector<std::uint32_t>
      island;  ///< one a slot: of a body asleep, the lowest slot of those that fell asleep with it
  std::vector<std::uint8_t> wake_requested;  ///< one a slot: the island of this name is to wake
  bool any_wake_requested = false;
  std::vector<std::uint32_t>
      changed_statics;  ///< static bodies that the caller put somewhere, changed or removed since the last step
  parallel::LargeVector<CachedPair> sleeping_pairs;  ///< of the pairs of which a body sleeps, sorted by slots
  std::size_t woken = 0;                             ///< since the last report

  parallel::LargeVector<CachedPair> next_awake, next_sleeping_pairs;  // scratch
  std::vector<std::uint32_t> parent;                                  // scratch: the union-find forest
  std::vector<std::uint8_t> restless;                                 // scratch: islands of which a body moves
};

/// What the time forecasts take from one frame to the next beside their coefficients. Not part of the state.
struct TimeFacts {
  std::uint64_t frames = 0;                             ///< learned from
  std::uint64_t candidate_pairs = 0, active_pairs = 0;  ///< of the last frame under a deadline
  double iterations_a_substep = 0;    ///< of places by resting contact, that a substep is likely to want
  Nanoseconds planning{0};            ///< FrameReport::planning of the last frame that was forecast infeasible
  std::uint64_t manifold_points = 0;  ///< of the last frame: visits that a substep makes at least
  scheduler::TailWork tail_work;      ///< of this frame; its contacts are those that were expected
  scheduler::TailWork head_work;
};

/// Everything that a World holds.
struct WorldState {
  WorldState() = default;
  WorldState(const WorldState&) = delete;
  WorldState& operator=(const WorldState&) = delete;
  ~WorldState() { settle(); }
  /// Waits for workers that the last refinement gave up: before anything changes that they read.
  void settle() const {
    if (executor) executor->settle();
  }

  WorldSettings settings;
  std::unique_ptr<parallel::Executor> executor;
  dynamics::BodyStore bodies;
  std::vector<std::uint32_t> shape_of;  // per slot: index into shapes
  std::vector<ShapeFacts> shapes;
  std::vector<Material> materials;
  std::vector<std::uint8_t> material_removed;  // one a material
  PairFilter pair_filter;
  std::uint64_t frame = 0;
  std::uint64_t changes = 1;                         // of where bodies are and which there are: what queries go by
  parallel::BuiltOnce<query::BodyIndex> body_index;  // made by the first query

  parallel::LargeVector<CachedPair> memory;  // of the last step's active pairs, sorted
  parallel::LargeVector<CachedPair> next_memory;
  ContactCache points;                         // of memory and of what sleeps
  std::vector<BodyId> removed_bodies;          // since the last step
  std::vector<std::uint32_t> displaced_slots;  // likewise: put somewhere else by the caller
  Sleep sleep;
  parallel::BuiltOnce<std::vector<Contact>> contacts;  // of the last step, made when somebody asks
  std::uint64_t contacts_version = 0;                  // of what contacts are made from; 0: there was no step
  std::vector<ContactEvent> events;
  std::vector<ContactEvent> removal_events;  // ends of contacts of removed bodies, for the events of the step

  collision::BroadPhase broad_phase;
  CandidateCache candidates;
  scheduler::PriorityBands bands;
  scheduler::RoundSelector rounds;
  scheduler::TailForecast tail;
  scheduler::TrackedQuantile margin;
  scheduler::DurationForecast host_work;
  scheduler::TailForecast head;  // of what comes before refinement; its contacts are the active pairs
  TimeFacts times;
  int substeps = 2;          // of this frame; fewer than the settings say where it was degraded
  double solved_share = 1;   // of the pairs that are not apart; learned
  double unit_cost_ns = 60;  // prior; replaced by what is measured
  double rank_cost_ns = 30;  // likewise: of putting a pair where its turn is, by all workers together
  FrameBuffers buffers;
  OpenRefinement open;
  solver::ContactSolver contact_solver;
  std::unique_ptr<Reference> reference;
  std::unique_ptr<DecisionLog> decisions;  // once a step was recorded
};

}  // namespace poise::simulation
