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
  /// Deadline: when the step must have returned. One that is more than kFarthestTime away, either way, counts as
  /// kFarthestTime away.
  SteadyClock::time_point deadline{};
  std::uint64_t work_units = 0;  ///< Work: node-pair expansions (8 x 8 blocks) that refinement may charge

  static Budget unlimited() { return {}; }
  static Budget until(SteadyClock::time_point deadline) { return {Kind::Deadline, deadline, 0}; }
  static Budget within(Nanoseconds time) { return until(saturating_add(SteadyClock::now(), time)); }
  static Budget work(std::uint64_t units) { return {Kind::Work, {}, units}; }
};

/// The viewer's camera and gaze. They set the order of refinement and nothing else.
struct View {
  bool present = false;  ///< without a view all pairs weigh the same
  Vec3 position_m = Vec3::Zero();
  Vec3 forward = Vec3::UnitX();    ///< unit
  Vec3 up = Vec3::UnitZ();         ///< unit, not parallel to forward
  double vertical_fov_rad = 0.87;  ///< in (0, pi)
  double aspect = 16.0 / 9.0;      ///< width / height, > 0
  Vec3 gaze = Vec3::UnitX();       ///< unit direction that the viewer looks along
};

/// Work of the host (rendering, game logic) that must still happen before the deadline, reserved like the response.
struct HostWork {
  bool learn = false;       ///< reserve what World::report_host_work lets expect, instead of `expected`
  Nanoseconds expected{0};  ///< >= 0; more than kFarthestTime counts as kFarthestTime
};

/// Longest step: beyond it, what the limits of speeds and accelerations allow would leave the range of double.
inline constexpr double kMaxTimeStepS = 1000.0;

struct StepInput {
  double dt_s = 1.0 / 60.0;  ///< length of the step, > 0 and at most kMaxTimeStepS
  Budget budget{};
  View view{};
  HostWork host_work{};
  Level max_level = kMaxTreeDepth;  ///< no pair is refined beyond this level of its trees
  bool polygons = false;  ///< one more level, by the triangles of meshes, for pairs whose trees end within max_level
  /// Continuous collision: a body that moves farther in the step than half its least extent (the smallest side of its
  /// box in principal axes) is stopped at its time of impact. It stays there until the end of the step, with its new
  /// velocity. Off, this costs nothing.
  bool backtracking = false;
  /// Fill FrameReport::levels; not part of the frame's times. Lists the contacts of the step and allocates.
  bool measure_levels = false;
  /// World::contact_events tells also of pairs that go on touching. Pairs of bodies that sleep are not told of.
  bool persist_events = false;
  bool measure_energy = false;  ///< fill FrameReport::kinetic_j and potential_j; not part of the frame's times
  /// Compute the frame a second time as a reference and fill FrameReport::reference. The state after the step is the
  /// same to the bit as without. Its cost is in none of the frame's times: the deadline moves by the copy of the
  /// bodies' state before the frame, and the rest is done after it, before step returns.
  bool reference = false;
  /// Receives time spans of all threads; null: no trace. Filled after the frame, in none of its times.
  Trace* trace = nullptr;
  /// Record the decisions of the budget for World::decisions; not with `replay`. Off, this costs nothing.
  bool record = false;
  /// Refine exactly these levels, whatever `budget` says. Valid until step returns. With it the state after the step is
  /// that of the step which made these decisions, to the bit, on any number of threads, if the state before it was.
  const FrameDecisions* replay = nullptr;
  /// With `replay`: filled with the cues and scores of each pair. Takes extra memory and time.
  FrameExplanation* explain = nullptr;
};

enum class StepStatus : std::uint8_t {
  Done,
  RefusedTimeStep,  ///< dt_s is not in (0, kMaxTimeStepS]; the World is unchanged
  RefusedView,      ///< the view has a part that is not finite or out of range; the World is unchanged
  RefusedHostWork,  ///< negative host work; the World is unchanged
  RefusedReplay,    ///< the decisions are those of a step with another number; the World is unchanged
  ReplayDiffers,    ///< done, but the decisions name pairs or levels that this step has not, or fronts was full:
                    ///< another state
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

/// Levels that a step reached, beside FrameReport::level_histogram. Array indices are levels; the last one is polygons.
struct LevelsReached {
  std::array<std::uint32_t, kPolygonBin + 1>
      bodies{};  ///< moving bodies with a contact, by the least level of their contacts
  /// Of contacts, by level: sums of what a viewer can notice of a metre of error there, rad/m: visible angle, frustum,
  /// eccentricity, importance (scheduler/policy.h); without a view all contacts of alike importance weigh the same.
  std::array<double, kPolygonBin + 1> weight{};
  std::size_t left_for_time = 0;      ///< pairs that could be refined further and were not because the budget ended
  std::size_t left_for_capacity = 0;  ///< likewise because their front was full
  std::uint32_t longest_wait = 0;     ///< most frames since one of these was refined beyond level 0
};

/// Work that a frame left out because its mandatory work was forecast not to fit before the deadline;
/// docs/scheduling.md.
struct Degraded {
  int substeps = 0;              ///< of resting contact, fewer than WorldSettings::substeps; 0: as many
  std::size_t pairs_reused = 0;  ///< pairs that reused their last contact although its certainty had expired
  /// The resting-contact solver stopped after this many point iterations in a substep, before it converged; 0: it was
  /// not stopped.
  std::uint32_t point_iterations = 0;
  [[nodiscard]] bool any() const { return substeps > 0 || pairs_reused > 0 || point_iterations > 0; }
};

/// What one step did. Plain numbers; no part points into the World.
struct FrameReport {
  StepStatus status = StepStatus::Done;
  std::uint64_t frame = 0;                   ///< number of steps done before this one
  SteadyClock::time_point started{};         ///< when the frame's times begin
  SteadyClock::time_point refine_started{};  ///< likewise those of refinement
  StageTimes times;

  // Budget (wall clock only; 0 otherwise)
  Nanoseconds budget{0};            ///< from the start of the step to its deadline
  Nanoseconds reserve_at_cut{0};    ///< reserved for the tail when refinement ended, tail_left_over excluded
  Nanoseconds tail_forecast{0};     ///< point forecast of the tail, without margin
  Nanoseconds tail_left_over{0};    ///< of tail_forecast: for iterations of resting contact made in time left over
  Nanoseconds tail_actual{0};       ///< from the end of refinement to the end of the step
  bool tail_beyond_clip = false;    ///< tail_actual / tail_forecast is outside the range of the bound on misses
  scheduler::TailWork tail_work;    ///< that tail_forecast was made for
  Nanoseconds planning{0};          ///< of StageTimes::refine: computing the reserve and choosing what is left out
  Nanoseconds refine_available{0};  ///< from the start of refinement to t_cut, 0 if there was none
  Nanoseconds host_reserved{0};
  Nanoseconds host_actual{0};  ///< what the host's work took, where the driver of the frame measures it; World does not
  /// All but refinement, host work included, without time that the system took away and without iterations of resting
  /// contact beyond one a substep (these by forecast).
  Nanoseconds mandatory{0};
  Nanoseconds mandatory_forecast{0};  ///< point forecast of that, made when the frame began
  bool infeasible_forecast = false;   ///< the forecast mandatory work, without the tail's margin, does not fit
  Degraded degraded;                  ///< what was left out so that it fits
  Nanoseconds lateness{0};            ///< past the deadline (host work included), 0 if on time
  MissCause cause = MissCause::None;
  Nanoseconds off_cpu{0};          ///< wall time less thread CPU time less own waits, of the calling thread
  Nanoseconds waited{0};           ///< by the calling thread, for refinement begun by other workers
  Nanoseconds longest_job{0};      ///< of a bounded piece of refinement
  Nanoseconds longest_overrun{0};  ///< of a piece beyond its forecast, or of refinement beyond its cut
  double cut_margin = 1;           ///< reserve / point forecast

  // Counted work
  std::size_t bodies = 0;           ///< dynamic bodies, those asleep included
  std::size_t candidate_pairs = 0;  ///< from the broad phase
  std::size_t coarse_pairs = 0;     ///< those that overlap at their mandatory level
  std::size_t contact_pairs = 0;    ///< with a contact
  std::uint64_t point_iterations =
      0;  ///< of resting contact, over all iterations and substeps; one with extrapolation counts seven times
  std::uint64_t work_mandatory = 0;  ///< node-pair expansions of the mandatory part
  std::uint64_t work_refine =
      0;  ///< node-pair expansions charged by completed refinement, polygons at what they cost in these
  std::size_t jobs_done = 0;           ///< levels completed
  std::size_t jobs_discarded = 0;      ///< started and not completed, or completed too late
  std::size_t jobs_abandoned = 0;      ///< of these, held by threads that the system had suspended: not waited for
  std::size_t pairs_separated = 0;     ///< found apart by refinement
  std::size_t cached_separations = 0;  ///< known from the contact cache to be separated: no refinement
  std::size_t cached_contacts = 0;     ///< taken from the contact cache
  std::size_t pairs_left = 0;          ///< still refinable when refinement ended
  std::array<std::uint32_t, kPolygonBin + 1>
      level_histogram{};  ///< contact pairs by completed level; at kPolygonBin those by polygons

  // With StepInput::backtracking
  std::size_t swept_pairs = 0;  ///< pairs with a fast body, sent to backtracking
  std::size_t swept_hits = 0;   ///< of these, with an impact within the step
  std::size_t swept_cut = 0;    ///< of them stopped short because their work ran out; they go on in the next step

  // With WorldSettings::sleeping
  std::size_t asleep = 0;       ///< bodies asleep after the step
  std::size_t fell_asleep = 0;  ///< at the end of the step
  std::size_t woken = 0;        ///< in the step, or by calls since the one before

  // Capacities that were full (0 in a healthy frame)
  std::size_t pairs_discarded = 0;  ///< candidate partners of a body beyond its limit
  std::size_t fronts_full = 0;      ///< refinements refused because a front was full
  std::size_t colors_full = 0;      ///< contacts beyond the last colour, solved one after another
  /// Answers of the host's cue (Policy::cue) that were NaN, which counts as 1, or out of range, which counts as the
  /// nearest end. 0 with a sound cue.
  std::size_t cues_refused = 0;
  std::size_t degenerate = 0;  ///< contacts without a positive finite effective mass, answered by none

  // After the step, if StepInput::measure_energy; the potential is 0 at the world origin
  double kinetic_j = 0;
  double potential_j = 0;

  std::optional<LevelsReached> levels;        ///< if StepInput::measure_levels
  std::optional<ReferenceFigures> reference;  ///< if StepInput::reference
};

}  // namespace poise
