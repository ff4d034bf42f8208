// SPDX-License-Identifier: MIT
#include "poise/scheduler/miss_cause.h"

namespace poise::scheduler {

MissCause classify(const LatenessFacts& facts) {
  if (facts.lateness.count() <= 0) return MissCause::None;
  const std::chrono::nanoseconds own = facts.lateness - facts.release_delay;
  if (own.count() <= 0) return MissCause::Release;
  if (facts.mandatory > facts.budget) return MissCause::Infeasible;
  if (facts.off_cpu >= own) return MissCause::Machine;
  if (facts.longest_overrun + facts.overrun_off_cpu >= own)
    return facts.overrun_off_cpu > facts.longest_overrun ? MissCause::Machine : MissCause::Overrun;
  return MissCause::Forecast;
}

}  // namespace poise::scheduler
