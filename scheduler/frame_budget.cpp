// SPDX-License-Identifier: MIT
#include "poise/scheduler/frame_budget.h"

#include <algorithm>
#include <array>
#include <limits>

namespace poise::scheduler {
namespace {

using Count = Nanoseconds::rep;
constexpr Count kMost = std::numeric_limits<Count>::max();
constexpr Count kLeast = std::numeric_limits<Count>::min();

// The largest double below kMost.
constexpr double kMaxBudgetNs = 9223372036854774784.0;

Nanoseconds from_ns(double ns) { return Nanoseconds(static_cast<Count>(std::clamp(ns, -kMaxBudgetNs, kMaxBudgetNs))); }

Count sum(Count x, Count y) {
  if (y > 0 && x > kMost - y) return kMost;
  if (y < 0 && x < kLeast - y) return kLeast;
  return x + y;
}

Count difference(Count x, Count y) {
  if (y < 0 && x > kMost + y) return kMost;
  if (y > 0 && x < kLeast + y) return kLeast;
  return x - y;
}

// The forecast is linear in the number of items, so two values determine it. A large number makes rounding to
// nanoseconds negligible.
constexpr std::uint64_t kProbe = 1'000'000;

FrameBudget budget_of(TimePoint deadline, Nanoseconds host_work, Nanoseconds without, Nanoseconds with_probe,
                      const TrackedQuantile& margin, double unit_cost_ns) {
  FrameBudget budget;
  budget.limited = true;
  budget.deadline = deadline;
  budget.host_work = host_work;
  budget.tail_fixed = without;
  budget.tail_per_contact_ns = static_cast<double>((with_probe - without).count()) / kProbe;
  budget.margin = margin.factor();
  budget.unit_cost_ns = unit_cost_ns;
  return budget;
}

}  // namespace

Nanoseconds FrameBudget::tail_forecast(std::uint64_t contacts) const {
  return Nanoseconds(sum(tail_fixed.count(), from_ns(tail_per_contact_ns * static_cast<double>(contacts)).count()));
}

Nanoseconds FrameBudget::reserve(std::uint64_t contacts) const {
  const Nanoseconds forecast = tail_forecast(contacts);
  const Nanoseconds all(sum(forecast.count(), tail_optional.count()));
  return std::max(from_ns(margin * static_cast<double>(forecast.count())), all);
}

TimePoint FrameBudget::cut(std::uint64_t contacts) const {
  const Count at = difference(deadline.time_since_epoch().count(), host_work.count());
  return std::max(earliest_cut, TimePoint(Nanoseconds(difference(at, reserve(contacts).count()))));
}

Nanoseconds FrameBudget::job_cost(std::uint64_t units) const {
  return from_ns(job_overhead_ns + unit_cost_ns * static_cast<double>(units));
}

bool FrameBudget::admits(TimePoint now, std::uint64_t units, std::uint64_t contacts) const {
  if (!limited) return true;
  return sum(now.time_since_epoch().count(), job_cost(units).count()) <= cut(contacts).time_since_epoch().count();
}

FrameBudget make_frame_budget(TimePoint deadline, Nanoseconds host_work, const TailForecast& tail,
                              const TrackedQuantile& margin, TailWork work, double unit_cost_ns) {
  work.contacts = 0;
  const Nanoseconds without = tail.forecast(work);
  work.contacts = kProbe;
  return budget_of(deadline, host_work, without, tail.forecast(work), margin, unit_cost_ns);
}

FrameBudget make_frame_budget(TimePoint deadline, Nanoseconds host_work, const LinearForecast& tail,
                              const TrackedQuantile& margin, std::span<const double> values, std::size_t varying,
                              double value_per_item, double unit_cost_ns) {
  std::array<double, LinearForecast::kMostFeatures> probe{};
  const std::size_t size = std::min(values.size(), probe.size());
  std::copy_n(values.begin(), size, probe.begin());
  const std::span<const double> probed = std::span(probe).first(size);
  if (varying >= size) {
    return budget_of(deadline, host_work, tail.forecast(values), tail.forecast(values), margin, unit_cost_ns);
  }
  probe[varying] = 0;
  const Nanoseconds without = tail.forecast(probed);
  probe[varying] = value_per_item * static_cast<double>(kProbe);
  return budget_of(deadline, host_work, without, tail.forecast(probed), margin, unit_cost_ns);
}

}  // namespace poise::scheduler
