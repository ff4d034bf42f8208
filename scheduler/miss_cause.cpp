// SPDX-License-Identifier: MIT
#include "poise/scheduler/miss_cause.h"

namespace poise::scheduler {

MissCause classify(const LatenessFacts& facts) {
  if (facts.lateness.count() <= 0) return MissCause::None;
  if (facts.mandatory > facts.budget) return MissCause::Infeasible;
  if (facts.off_cpu >= facts.lateness) return MissCause::Machine;
  if (facts.longest_overrun >= facts.lateness) return MissCause::Overrun;
  return MissCause::Forecast;
}

}  // namespace poise::scheduler
