// SPDX-License-Identifier: MIT
#include "poise/scheduler/frame_budget.h"

#include <algorithm>

namespace poise::scheduler {
namespace {

Nanoseconds from_ns(double ns) { return Nanoseconds(static_cast<std::int64_t>(ns)); }

}  // namespace

Nanoseconds FrameBudget::reserve(std::uint64_t contacts) const {
  return tail_fixed + from_ns(tail_per_contact_ns * static_cast<double>(contacts));
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
  constexpr std::uint64_t kProbe = 1000;
  work.contacts = 0;
  const double fixed_ns = static_cast<double>(tail.forecast(work).count());
  work.contacts = kProbe;
  const double probe_ns = static_cast<double>(tail.forecast(work).count());
  FrameBudget budget;
  budget.limited = true;
  budget.deadline = deadline;
  budget.host_work = host_work;
  budget.tail_fixed = from_ns(fixed_ns * margin.factor());
  budget.tail_per_contact_ns = std::max(0.0, (probe_ns - fixed_ns) / kProbe) * margin.factor();
  budget.unit_cost_ns = unit_cost_ns;
  return budget;
}

Lateness classify(const LatenessFacts& facts) {
  if (facts.lateness.count() <= 0) return Lateness::OnTime;
  if (facts.mandatory > facts.budget) return Lateness::Infeasible;
  if (facts.off_cpu >= facts.lateness) return Lateness::Machine;
  if (facts.longest_overrun >= facts.lateness) return Lateness::Overrun;
  return Lateness::Forecast;
}

}  // namespace poise::scheduler
