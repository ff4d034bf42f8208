// SPDX-License-Identifier: MIT
#pragma once

#include "frame/refine/refine.h"
#include "parallel/executor.h"
#include "poise/scheduler/frame_budget.h"
#include "world/forecasts.h"

/// What a frame under a deadline expects its time to be, and what came of it. For the step, from its thread.
namespace poise::simulation {

/// Where all pairs take no more than so much of the time that refinement has, they are refined in the order of memory:
/// by score each takes longer, which only pays where some are left. More of it in slices, where a forecast that was
/// wrong costs a frame and makes none late. Chosen.
inline constexpr double kInOrderOfTime = 0.5, kInOrderOfSlices = 0.9;

/// Where the share of refinement comes out of the margin of the tail, so much of it is left. Chosen.
inline constexpr double kMarginLeft = 0.25;

/// A step in slices has as many frames as it takes for so much of what refinement has to do, by score. Chosen: more
/// than the third without which islands wait (frame_time.cpp), and what steps that are done at once again have time
/// for.
inline constexpr double kRefinedInSlices = 0.4;

/// What the forecasts ask of a frame beside its report.
struct FrameCounts {
  ContactModel contact = ContactModel::Fitted;
  std::size_t dynamic_bodies = 0;
  int substeps = 2;  ///< of the settings
  const PairTable& table;
  const CompletedLevels& levels;
  std::size_t held_found = 0;  ///< after the manifolds: of pairs that wait, those with new contact points
  bool leaves_out = false;     ///< after them: the policy does, so pairs that are left may want nothing
};

/// Where the time of the calling thread went in a frame.
struct CallerTime {
  Nanoseconds cpu{0};     ///< on a processor
  parallel::Waits waits;  ///< asleep, but for jobs of refinement
};

/// Begins a frame: forecasts what it must do, from the counts of the frame before. Only under a deadline.
void begin_frame_time(const StepInput& step, std::size_t dynamic_bodies, int substeps, SteadyClock::time_point start,
                      Forecasts& forecasts, FrameReport& report);

/// What a frame of so many bodies must do, host work included; from the counts of the frame before.
[[nodiscard]] Nanoseconds mandatory_forecast(const StepInput& step, std::size_t dynamic_bodies, int substeps,
                                             const Forecasts& forecasts);
/// Of what is left of a frame at `now`, what the step itself has: all but host work.
[[nodiscard]] Nanoseconds time_of_step(const StepInput& step, SteadyClock::time_point now, const Forecasts& forecasts);

/// Of the time `left` of a frame, what refinement has before the rest has its margin, if all of it takes `all_ns`. What
/// pairs cost as long as nothing is known of them they cost in every frame; what is found out of them they cost once.
[[nodiscard]] Nanoseconds share_of_refinement(double all_ns, Nanoseconds left);

/// Before the broad phase, at `now`: how many partners each body in a crowd may have if all pairs of the frame are to
/// end before the deadline. 0: as many as the settings allow (`most`), as without a deadline.
std::uint32_t crowded_partners_in_time(const StepInput& step, std::size_t dynamic_bodies, std::uint32_t most,
                                       SteadyClock::time_point now, const Forecasts& forecasts);

/// What refinement goes by.
struct FramePlan {
  scheduler::FrameBudget budget;
  SteadyClock::time_point deadline;  ///< of the step: that of its input, or where slices end
  std::int64_t present = 0;          ///< pairs that are not known to be separated
  std::uint64_t expected = 0;        ///< pairs that are likely to have a contact
  double share = 1;                  ///< of the pairs with a contact: those that do not wait (budget/hold.h)
  Nanoseconds time_left{0};          ///< until the deadline, when the plan was begun
  int threads = 1;
};

/// After the pairs were found, at `now`: the reserve, and where what must be done does not fit before the deadline any
/// more, less of it (budget/degrade.h, budget/hold.h). Fills what the report says of both.
FramePlan plan_frame(const RefineInput& input, SteadyClock::time_point now, Forecasts& forecasts,
                     CompletedLevels& levels, FrameReport& report, parallel::Executor& executor);

/// After the manifolds are listed, at `now`: how many point iterations a substep may make
/// (solver::SolveSettings::point_iterations) so that the tail is likely to end in time; as many as the solver makes by
/// itself where that fits. At least 1.
std::uint32_t iterations_in_time(const Forecasts& forecasts, SteadyClock::time_point deadline,
                                 const FrameCounts& counts, SteadyClock::time_point now, std::uint64_t manifold_points,
                                 const FrameReport& report);

/// When the last of them is to end, so that what comes after it, with its margin, ends in time.
SteadyClock::time_point iterations_end(const Forecasts& forecasts, SteadyClock::time_point deadline,
                                       const FrameCounts& counts, const FrameReport& report);

/// Of so many pairs that are not separated, how many are likely to have a contact.
std::uint64_t expected_solved(const Forecasts& forecasts, std::int64_t present);

/// Counted work of the tail with this many contacts; point iterations and coarse contacts are those of TimeFacts.
scheduler::TailWork tail_work(const Forecasts& forecasts, const FrameCounts& counts, std::uint64_t contacts);

/// After the last stage: how late the frame was and why, and what the forecasts learn from it. Reads the
/// report's stage times.
void account_time(const StepInput& step, const FrameCounts& counts, std::uint64_t manifold_points,
                  const CallerTime& caller, Forecasts& forecasts, FrameReport& report);

/// How late a frame was in which a part of a step was done, and why. `caller` is the thread of that step.
void account_slice(const StepInput& step, const CallerTime& caller, FrameReport& report);

/// Classifies a frame anew once the host's own work of it is done: it took `actual` from the end of the step, of which
/// the machine took away `off_cpu`. A pure function of the report.
void add_host_work(Nanoseconds actual, Nanoseconds off_cpu, FrameReport& report);

/// Begins learning anew, from what an earlier run came to.
void forget_times(Forecasts& forecasts, double alpha, const scheduler::TimePriors& priors);
scheduler::TimePriors times_of(const Forecasts& forecasts);

}  // namespace poise::simulation
