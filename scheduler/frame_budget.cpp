// SPDX-License-Identifier: MIT
#include "poise/scheduler/frame_budget.h"

#include <algorithm>

namespace poise::scheduler {
namespace {

Nanoseconds from_ns(double ns) { return Nanoseconds(static_cast<std::int64_t>(ns)); }

}  // namespace

Nanoseconds FrameBudget::tail_forecast(std::uint64_t contacts) const {
  return tail_fixed + from_ns(tail_per_contact_ns * static_cast<double>(contacts));
}

Nanoseconds FrameBudget::reserve(std::uint64_t contacts) const {
  return from_ns(margin * static_cast<double>(tail_forecast(contacts).count()));
}

Nanoseconds FrameBudget::job_cost(std::uint64_t units) const {
  return from_ns(job_overhead_ns + unit_cost_ns * static_cast<double>(units));
}

bool FrameBudget::admits(TimePoint now, std::uint64_t units, std::uint64_t contacts) const {
  if (!limited) return true;
  return now + job_cost(units) <= cut(contacts);
}

FrameBudget make_frame_budget(TimePoint deadline, Nanoseconds host_work, const TailForecast& tail,
                              const TrackedQuantile& margin, TailWork work, double unit_cost_ns) {
  // The forecast is linear in contacts, so two values give all; many contacts, so that rounding to nanoseconds is
  // nothing.
  constexpr std::uint64_t kProbe = 1'000'000;
  FrameBudget budget;
  budget.limited = true;
  budget.deadline = deadline;
  budget.host_work = host_work;
  work.contacts = 0;
  budget.tail_fixed = tail.forecast(work);
  work.contacts = kProbe;
  budget.tail_per_contact_ns = static_cast<double>((tail.forecast(work) - budget.tail_fixed).count()) / kProbe;
  budget.margin = margin.factor();
  budget.unit_cost_ns = unit_cost_ns;
  return budget;
}

}  // namespace poise::scheduler
