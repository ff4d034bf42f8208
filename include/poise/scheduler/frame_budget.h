// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <span>

#include "poise/scheduler/forecast.h"

namespace poise::scheduler {

/// A point in time that the caller read from its clock; the scheduler has no clock.
using TimePoint = std::chrono::steady_clock::time_point;

/// Decides, job by job, whether refinement may continue: t_cut = deadline - host work still to come - reserve. The
/// reserve is the forecast of what the tail (the part after refinement) must do for the contacts that are published
/// now, times the tracked margin; and no less than that forecast without a margin and what the tail may do beside: it
/// leaves that out where the rest takes longer. A plain value for one frame; any number of threads may read it. It does
/// not depend on geometry: a *contact* is any item that the tail has to process, a *unit* any amount of refinement.
/// Sums saturate at the range of TimePoint.
struct FrameBudget {
  bool limited = false;            ///< false: there is no deadline
  TimePoint deadline{};            ///< of the frame, host work included
  Nanoseconds host_work{0};        ///< still to come after the step
  Nanoseconds tail_fixed{0};       ///< point forecast of the tail without contacts
  double tail_per_contact_ns = 0;  ///< point forecast for each contact
  Nanoseconds tail_optional{0};    ///< what the tail does beside where there is time; no margin is kept for it
  double margin = 1;               ///< factor from point forecast to reserve
  TimePoint earliest_cut = TimePoint::min();  ///< refinement may go on until here, whatever the reserve
  double unit_cost_ns = 40;                   ///< of one unit (Poise: a node-pair expansion) on one thread, nanoseconds
  double job_overhead_ns = 150;

  /// Point forecast of what the tail must do for this number of contacts; the margin is tracked against it.
  [[nodiscard]] Nanoseconds tail_forecast(std::uint64_t contacts) const;
  /// Time reserved for the tail with this number of contacts.
  [[nodiscard]] Nanoseconds reserve(std::uint64_t contacts) const;
  /// Time at which refinement must end, for this number of contacts.
  [[nodiscard]] TimePoint cut(std::uint64_t contacts) const;
  /// Whether a job of `units` units that begins at `now` is forecast to end before the cut.
  [[nodiscard]] bool admits(TimePoint now, std::uint64_t units, std::uint64_t contacts) const;
  /// Forecast of a job's duration, overhead included.
  [[nodiscard]] Nanoseconds job_cost(std::uint64_t units) const;
};

/// Makes the budget of a frame from the forecasts, for the tail work that is known before refinement. `work.contacts`
/// is ignored, since it changes while levels complete.
FrameBudget make_frame_budget(TimePoint deadline, Nanoseconds host_work, const TailForecast& tail,
                              const TrackedQuantile& margin, TailWork work, double unit_cost_ns);

/// The same for a host's own work. `values` are the values of the features of `tail`. Refinement changes the one at
/// index `varying` while it runs: its value here is ignored, and each item adds `value_per_item` to it (0.001 for a
/// feature in thousands). If `varying` is not an index of a feature, the tail does not depend on what is refined.
FrameBudget make_frame_budget(TimePoint deadline, Nanoseconds host_work, const LinearForecast& tail,
                              const TrackedQuantile& margin, std::span<const double> values, std::size_t varying,
                              double value_per_item, double unit_cost_ns);

}  // namespace poise::scheduler
