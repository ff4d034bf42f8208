// SPDX-License-Identifier: MIT
#include "poise/scheduler/refine_until.h"

#include <cmath>

namespace poise::scheduler {
namespace {

constexpr double kUnknownNs = 60;
constexpr double kLeastNs = 1e-3;
constexpr double kMaxLoopNs = 1e12;
// Weight of a new frame in the exponential mean. Chosen, as for Poise's own work.
constexpr double kShare = 0.2;

}  // namespace

void RefineCounts::add(const RefineCounts& other) {
  jobs += other.jobs;
  parts += other.parts;
  units += other.units;
  discarded += other.discarded;
  abandoned += other.abandoned;
  left += other.left;
  cut = cut || other.cut;
  busy += other.busy;
  longest = std::max(longest, other.longest);
  overrun = std::max(overrun, other.overrun);
  ended = std::max(ended, other.ended);
}

UnitCost::UnitCost(double first_ns)
    : ns_(std::isfinite(first_ns) && first_ns > 0 ? std::clamp(first_ns, kLeastNs, kMaxLoopNs) : kUnknownNs) {}

void UnitCost::learn(const RefineCounts& counts, double job_overhead_ns) {
  if (counts.units < kLeastUnits) return;
  const double work_ns = static_cast<double>(counts.busy.count()) - job_overhead_ns * static_cast<double>(counts.parts);
  const double measured = std::clamp(work_ns / static_cast<double>(counts.units), kLeastNs, kMaxLoopNs);
  if (std::isfinite(measured)) ns_ += kShare * (measured - ns_);
}

}  // namespace poise::scheduler
