// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <span>

#include "poise/scheduler/forecast.h"

namespace poise::scheduler {

/// A point in time that the caller read from its clock; the scheduler has none.
using TimePoint = std::chrono::steady_clock::time_point;

/// Decides, job by job, whether refinement may go on: t_cut = deadline - host work still to come - reserve, where the
/// reserve is the forecast of the whole tail (what follows refinement) for the contacts that are published now, times
/// the tracked margin. A plain value for one frame, read by any number of threads. Nothing in it is of Poise's
/// geometry: a *contact* is any item that the tail has to deal with, a *unit* any amount of refinement. Sums beyond the
/// range of TimePoint end at its ends.
struct FrameBudget {
  bool limited = false;            ///< false: there is no deadline
  TimePoint deadline{};            ///< of the frame, host work included
  Nanoseconds host_work{0};        ///< still to come after the step
  Nanoseconds tail_fixed{0};       ///< point forecast of the tail without contacts
  double tail_per_contact_ns = 0;  ///< and for each contact
  double margin = 1;               ///< reserve / point forecast
  double unit_cost_ns = 40;        ///< of one unit (Poise: a node-pair expansion) on one thread
  double job_overhead_ns = 150;

  /// Point forecast of the tail when `contacts` pairs are to be answered: what the margin is tracked against.
  [[nodiscard]] Nanoseconds tail_forecast(std::uint64_t contacts) const;
  /// What is kept for it.
  [[nodiscard]] Nanoseconds reserve(std::uint64_t contacts) const;
  [[nodiscard]] TimePoint cut(std::uint64_t contacts) const;
  /// May a job of `units` units begin at `now`?
  [[nodiscard]] bool admits(TimePoint now, std::uint64_t units, std::uint64_t contacts) const;
  /// Forecast of a job's duration.
  [[nodiscard]] Nanoseconds job_cost(std::uint64_t units) const;
};

/// Makes the budget of a frame from the forecasts, for the tail work that is known before refinement
/// (`work.contacts` is ignored: it changes while levels complete).
FrameBudget make_frame_budget(TimePoint deadline, Nanoseconds host_work, const TailForecast& tail,
                              const TrackedQuantile& margin, TailWork work, double unit_cost_ns);

/// The same for work of the host's choosing. `values` are those of the features of `tail`; the one at `varying` is what
/// refinement changes while it runs: its value here is ignored, and an item adds `value_per_item` to it (0.001 for a
/// feature in thousands). A `varying` that is no feature: the tail does not depend on what is refined.
FrameBudget make_frame_budget(TimePoint deadline, Nanoseconds host_work, const LinearForecast& tail,
                              const TrackedQuantile& margin, std::span<const double> values, std::size_t varying,
                              double value_per_item, double unit_cost_ns);

}  // namespace poise::scheduler
