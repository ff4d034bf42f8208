// SPDX-License-Identifier: MIT
#pragma once

#include "frame/stages.h"

/// What a frame under a deadline expects its time to be, and what came of it. For World::step, from its thread.
namespace poise::simulation {

/// Begins a frame: forecasts what it must do, from the counts of the frame before. Only under a deadline.
void begin_frame_time(WorldState& world, const StepInput& input, TimePoint start, FrameReport& report);

/// What refinement goes by.
struct FramePlan {
  scheduler::FrameBudget budget;
  std::int64_t present = 0;    ///< pairs that are not known to be apart
  std::uint64_t expected = 0;  ///< pairs that are likely to be answered
};

/// After the pairs were found, at `now`: the reserve, and where what must be done does not fit before the deadline any
/// more, less of it (simulation/degrade.h). Fills what the report says of both.
FramePlan plan_frame(WorldState& world, const StepInput& input, TimePoint now, FrameReport& report);

/// After the contacts were listed: of places, how many a substep may visit (solver::SolveSettings::visits) so that
/// the tail, with its margin, ends in time; as many as the solver does by itself where that fits. At least 1.
std::uint32_t iterations_in_time(const WorldState& world, const StepInput& input, const FrameReport& report);

/// Of so many pairs that are not apart, how many are likely to be answered.
std::uint64_t expected_solved(const WorldState& world, std::int64_t present);

/// After the last stage: how late the frame was and why, and what the forecasts learn from it. `cpu_before` is the time
/// on the CPU of this thread when the frame began.
void account_time(WorldState& world, const StepInput& input, TimePoint start, Nanoseconds cpu_before,
                  FrameReport& report);

/// Judges a frame anew once the host's own work of it is done: it took `actual` from the end of the step, of which the
/// machine took away `off_cpu`. A pure function of the report.
void add_host_work(Nanoseconds actual, Nanoseconds off_cpu, FrameReport& report);

/// Begins learning anew, from what an earlier run came to.
void forget_times(WorldState& world, const scheduler::TimePriors& priors);
scheduler::TimePriors times_of(const WorldState& world);

}  // namespace poise::simulation
