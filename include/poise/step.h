// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "poise/decisions.h"
#include "poise/reference.h"
#include "poise/scheduler/forecast.h"
#include "poise/scheduler/miss_cause.h"
#include "poise/time_arithmetic.h"
#include "poise/trace.h"
#include "poise/types.h"

namespace poise {

/// Limit of the work that a step does beyond its mandatory part.
struct Budget {
  enum class Kind : std::uint8_t { Unlimited, Deadline, Work };
  Kind kind = Kind::Unlimited;
  /// Deadline: the time by which the step must have returned. A deadline more than kFarthestTime before or after now is
  /// clamped to that distance.
  SteadyClock::time_point deadline{};
  std::uint64_t work_units = 0;  ///< Work: most node-pair expansions (8 x 8 blocks) of refinement

  static Budget unlimited() { return {}; }
  static Budget until(SteadyClock::time_point deadline) { return {Kind::Deadline, deadline, 0}; }
  static Budget within(Nanoseconds time) { return until(saturating_add(SteadyClock::now(), time)); }
  static Budget work(std::uint64_t units) { return {Kind::Work, {}, units}; }
};

/// The viewer's camera and gaze. They affect the order of refinement and nothing else.
struct View {
  bool present = false;            ///< without a view all pairs have the same visual weight
  Vec3 position_m = Vec3::Zero();  ///< world frame, as all of these
  Vec3 forward = Vec3::UnitX();    ///< unit
  Vec3 up = Vec3::UnitZ();         ///< unit, not parallel to forward
  double vertical_fov_rad = 0.87;  ///< in (0, pi)
  double aspect = 16.0 / 9.0;      ///< width / height, > 0
  Vec3 gaze = Vec3::UnitX();       ///< unit direction of the viewer's gaze
};

/// What matters to the host now, beside what the viewer sees: a ball of space, a body, or both. It affects the order of
/// refinement, with Policy::attention, and nothing else.
struct Attention {
  Vec3 center_m = Vec3::Zero();  ///< of the ball, world frame
  double radius_m = 0;           ///< contact points in the ball count; 0: there is no ball
  BodyId body;                   ///< all its pairs count; by default none, and none if it was removed
};

/// Work of the host (rendering, game logic) that must still run before the deadline; time is reserved for it.
struct HostWork {
  bool learn = false;       ///< reserve the duration learned from World::report_host_work instead of `expected`
  Nanoseconds expected{0};  ///< >= 0; more than kFarthestTime counts as kFarthestTime
};

/// Longest step. With a longer one, the limits of speeds and accelerations would allow results beyond the range of
/// double.
inline constexpr double kMaxTimeStepS = 1000.0;

/// Input of World::step.
struct StepInput {
  double dt_s = 1.0 / 60.0;  ///< length of the step, > 0 and at most kMaxTimeStepS
  Budget budget{};
  /// When the frame could have begun, for hosts with frames on a grid: by how much the step begins later is not held
  /// against it if it ends late (MissCause::Release). Changes nothing else. Empty: now. A time in the future counts as
  /// now, one more than kFarthestTime ago as that long ago.
  std::optional<SteadyClock::time_point> release{};
  View view{};
  Attention attention{};
  HostWork host_work{};
  Level max_level = kMaxTreeDepth;  ///< no pair is refined beyond this level of its trees
  bool polygons = false;  ///< one more level, by the triangles of meshes, for pairs whose trees end within max_level
  /// Continuous collision. A body that moves farther in the step than half its least extent (the smallest side of its
  /// box in principal axes) is stopped at its time of impact. It stays there until the end of the step, with its new
  /// velocity. Costs nothing if off.
  bool backtracking = false;
  /// Fill FrameReport::levels. Excluded from the frame's times. Lists the contacts of the step and allocates.
  bool measure_levels = false;
  /// World::contact_events also lists pairs that continue to touch, except pairs of sleeping bodies.
  bool persist_events = false;
  /// Fill FrameReport::kinetic_j, potential_j and momentum_ns; excluded from the frame's times.
  bool measure_energy = false;
  /// Compute the frame a second time as a reference and fill FrameReport::reference. The state after the step is the
  /// same to the bit as without. The cost is excluded from all times of the frame: the deadline is postponed by the
  /// time to copy the bodies' state before the frame, and the remaining work is done after the frame, before step
  /// returns.
  bool reference = false;
  /// Receives time spans of all threads; null: no trace. Filled after the frame, excluded from its times.
  Trace* trace = nullptr;
  /// Record the decisions of the budget for World::decisions. Ignored with `replay`. Costs nothing if off.
  bool record = false;
  /// Refine exactly these levels, whatever `budget` says. Must be valid until step returns. If the state before the
  /// step is the one before the recorded step, the state after it is the same to the bit, on any number of threads.
  const FrameDecisions* replay = nullptr;
  /// With a deadline: where the step, with a third of its refinement, does not fit into its frame, it may take several.
  /// Each call then returns in time, and until the last one no body moves (FrameReport::unfinished). So bodies move in
  /// slow motion. A step has as few frames as two fifths of its refinement take, eight or so at most. It goes by the
  /// input of the call that began it and is traced by stages alone; a call without a deadline ends it. A thread of the
  /// World takes the place of the calling one meanwhile, with its affinity and priority when it began. Not with
  /// `backtracking`, `reference` or ContactModel::Paper.
  bool may_slice = false;
  /// With `replay`: receives the cues and scores of each pair. Takes extra memory and time.
  FrameExplanation* explain = nullptr;
};

/// Whether a step was done or refused.
enum class StepStatus : std::uint8_t {
  Done,
  RefusedTimeStep,  ///< dt_s is not in (0, kMaxTimeStepS]; the World is unchanged
  RefusedView,      ///< a component of the view, or of the attention, is not finite or out of range; the World is
                    ///< unchanged
  RefusedHostWork,  ///< negative host work; the World is unchanged
  RefusedReplay,    ///< the decisions belong to a step with another number; the World is unchanged
  ReplayDiffers,    ///< done, but the decisions name pairs or levels that this step does not have, or a front was full:
                    ///< the state before the step was another one
};

/// Wall time of the stages of one step.
struct StageTimes {
  Nanoseconds predict{0};
  Nanoseconds broad_phase{0};
  Nanoseconds coarse{0};  ///< every candidate pair at its mandatory level
  Nanoseconds refine{0};
  Nanoseconds manifolds{0};  ///< contact points of all touching pairs, in pair order
  Nanoseconds solve{0};      ///< impacts, colouring, resting contact
  Nanoseconds integrate{0};
  Nanoseconds publish{0};  ///< events and report
  Nanoseconds total{0};
};

using scheduler::MissCause;

/// Levels that a step reached, in addition to FrameReport::level_histogram. Arrays are indexed by level; the last entry
/// is for polygons.
struct LevelsReached {
  /// Dynamic bodies with a contact, by the lowest level of their contacts.
  std::array<std::uint32_t, kPolygonBin + 1> bodies{};
  /// By level, the sum over its contacts of the visibility of one metre of error, rad/m: visible angle, frustum,
  /// eccentricity and importance (scheduler/policy.h). Without a view all contacts of the same importance have the same
  /// weight.
  std::array<double, kPolygonBin + 1> weight{};
  std::size_t left_for_time = 0;      ///< pairs that were not refined further because the budget ended
  std::size_t left_for_capacity = 0;  ///< pairs that were not refined further because their front was full
  std::uint32_t longest_wait = 0;     ///< most frames since one of these pairs was refined beyond level 0
};

/// Work that a frame left out because its mandatory work was forecast to end after the deadline; docs/scheduling.md.
struct Degraded {
  int substeps = 0;               ///< of the contact solver, if fewer than WorldSettings::substeps; else 0
  std::size_t pairs_reused = 0;   ///< pairs that reused an expired cached contact
  std::size_t bodies_held = 0;    ///< bodies of islands that waited: they kept position and velocity
  std::size_t bodies_paused = 0;  ///< of these, bodies that wait for several steps and cost nothing in between
  /// The contact solver stopped after this number of point iterations in a substep, before it converged; 0: it did not
  /// stop early.
  std::uint32_t point_iterations = 0;
  /// Bodies in crowds, where more lie in one place than solid ones can, kept this number of partners, or a quarter of
  /// the most that they could have outside of a crowd; FrameReport::pairs_discarded counts the others. 0: all kept
  /// theirs.
  std::uint32_t crowded_partners = 0;
  [[nodiscard]] bool any() const {
    return substeps > 0 || pairs_reused > 0 || bodies_held > 0 || point_iterations > 0 || crowded_partners > 0;
  }
};

/// Report of one step. Plain values; nothing in it refers to the World.
struct FrameReport {
  StepStatus status = StepStatus::Done;
  /// The step goes on in the next call (StepInput::may_slice): nothing has moved, and what is reported of pairs and
  /// contacts is 0: it stands in the report of the call that ends it. Stage times are those of each call.
  bool unfinished = false;
  std::uint64_t frame = 0;                   ///< number of calls that stepped before this one
  SteadyClock::time_point started{};         ///< the start of the frame's times
  SteadyClock::time_point refine_started{};  ///< the start of refinement
  StageTimes times;

  // Budget (wall clock only; 0 otherwise)
  Nanoseconds budget{0};          ///< from the start of the step to its deadline
  Nanoseconds release_delay{0};   ///< from StepInput::release to the start of the step
  Nanoseconds reserve_at_cut{0};  ///< reserved for the tail when refinement ended
  Nanoseconds tail_forecast{0};   ///< point forecast of what the tail must do, without margin
  Nanoseconds tail_actual{0};     ///< from the end of refinement to the end of the step
  /// Part of tail_actual: iterations of resting contact beyond one a substep, which are made as far as there is time.
  Nanoseconds tail_optional{0};
  /// What the tail had to do.
  [[nodiscard]] Nanoseconds tail_needed() const { return tail_actual - tail_optional; }
  bool tail_beyond_clip = false;  ///< tail_needed() / tail_forecast is outside the range in which the bound on missed
                                  ///< deadlines holds
  scheduler::TailWork tail_work;  ///< the work for which tail_forecast was made
  Nanoseconds planning{0};        ///< part of StageTimes::refine: computing the reserve and choosing the work to
                                  ///< leave out
  /// Part of StageTimes::refine: cues that look at all bodies, and scores of pairs before their first job. Jobs score
  /// a pair again after a level; that is not in it.
  Nanoseconds ranking{0};
  std::size_t pairs_ranked = 0;     ///< in that time; 0 where pairs went in the order of memory
  Nanoseconds refine_available{0};  ///< from the start of refinement to t_cut; 0 if t_cut was earlier
  Nanoseconds host_reserved{0};     ///< reserved for the host's work
  Nanoseconds host_actual{0};  ///< measured duration of the host's work, set by the caller of the frame; World does not
                               ///< set it
  /// Everything but refinement, host work included, without the time in which the system did not run the thread, and
  /// without tail_optional.
  Nanoseconds mandatory{0};
  Nanoseconds mandatory_forecast{0};  ///< point forecast of `mandatory` at the start of the frame
  bool infeasible_forecast = false;   ///< the forecast mandatory work, without the tail's margin, does not fit
  Degraded degraded;                  ///< the work left out so that it fits
  Nanoseconds lateness{0};            ///< past the deadline (host work included), 0 if on time
  MissCause cause = MissCause::None;
  /// Wall time minus thread CPU time minus own waits, of the calling thread; and of the waits the time in which the
  /// system did not run the worker that was waited for.
  Nanoseconds off_cpu{0};
  Nanoseconds waited{0};  ///< time in which the calling thread waited for other workers: at the end of refinement, and
                          ///< asleep in other stages
  Nanoseconds longest_job{0};           ///< longest bounded piece of refinement, without what the system took from it
  BodyId longest_job_a, longest_job_b;  ///< the pair that it was of
  /// Largest excess of a piece over its forecast, or of refinement over its cut, without what the system took from it.
  Nanoseconds longest_overrun{0};
  Nanoseconds overrun_off_cpu{0};  ///< what the system took from it
  double cut_margin = 1;           ///< factor from point forecast to reserve

  // Counted work
  std::size_t bodies = 0;           ///< dynamic bodies, sleeping ones included
  std::size_t candidate_pairs = 0;  ///< from the broad phase
  std::size_t coarse_pairs = 0;     ///< candidate pairs that are near at their mandatory level, apart or not
  std::size_t contact_pairs = 0;    ///< with a contact
  /// Point iterations of the contact solver, over all iterations and substeps; one with extrapolation counts seven
  /// times.
  std::uint64_t point_iterations = 0;
  std::uint64_t work_mandatory = 0;  ///< node-pair expansions of the mandatory part
  /// Node-pair expansions charged by completed refinement; polygons are charged at their equivalent cost.
  std::uint64_t work_refine = 0;
  std::size_t jobs_done = 0;           ///< levels completed
  std::size_t jobs_discarded = 0;      ///< levels that were begun and not completed, or completed too late
  std::size_t jobs_abandoned = 0;      ///< of these, levels on threads that the system had suspended: not waited for
  std::size_t pairs_separated = 0;     ///< separated by refinement
  std::size_t cached_separations = 0;  ///< known from the contact cache to be separated: not refined
  std::size_t cached_contacts = 0;     ///< taken from the contact cache
  std::size_t pairs_left = 0;          ///< still refinable when refinement ended
  /// Contact pairs by completed level; pairs solved by polygons at kPolygonBin.
  std::array<std::uint32_t, kPolygonBin + 1> level_histogram{};

  // With StepInput::backtracking
  std::size_t swept_pairs = 0;  ///< pairs with a fast body, checked for a time of impact
  std::size_t swept_hits = 0;   ///< impacts within the step that gave an impulse
  std::size_t swept_cut = 0;    ///< searches for a time of impact that reached their work limit: the bodies stop there,
                                ///< and continue in the next step

  // With WorldSettings::sleeping
  std::size_t asleep = 0;       ///< bodies asleep after the step
  std::size_t fell_asleep = 0;  ///< at the end of the step
  std::size_t woken = 0;        ///< in the step, or by calls since the previous step

  // Full capacities (all 0 in a healthy frame, but colors_full where a body has more than 56 partners)
  std::size_t pairs_discarded = 0;  ///< candidate pairs beyond WorldSettings::max_partners and max_pairs
  std::size_t fronts_full = 0;      ///< refinements refused because a front was full
  /// Contacts of bodies that have more partners than there are colours. These are solved on copies of the bodies.
  std::size_t colors_full = 0;
  /// Results of the host's cue (Policy::cue) that were NaN (counts as 1) or out of range (counts as the nearest end). 0
  /// with a valid cue.
  std::size_t cues_refused = 0;
  std::size_t degenerate = 0;  ///< contacts without a positive finite effective mass, which are not solved
  /// Bodies that the step would have taken beyond the limits of BodyState, or to numbers that are not finite: they are
  /// at rest where they were before it, and their contacts in it gave nothing.
  std::size_t out_of_range = 0;
  BodyId out_of_range_body;  ///< of these, the one in the first slot

  // After the step, with StepInput::measure_energy; the potential is 0 at the world origin
  double kinetic_j = 0;
  double potential_j = 0;
  Vec3 momentum_ns = Vec3::Zero();  ///< linear, of the dynamic bodies, kg m/s

  std::optional<LevelsReached> levels;        ///< if StepInput::measure_levels
  std::optional<ReferenceFigures> reference;  ///< if StepInput::reference
};

}  // namespace poise
