// SPDX-License-Identifier: MIT
#include "poise/scheduler/miss_cause.h"

#include <gtest/gtest.h>

namespace poise::scheduler {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using Nanoseconds = std::chrono::nanoseconds;

LatenessFacts late_by(Nanoseconds lateness) {
  LatenessFacts facts;
  facts.lateness = lateness;
  facts.budget = milliseconds(16);
  facts.mandatory = milliseconds(5);
  return facts;
}

TEST(MissCause, NamesOneCauseEach) {
  EXPECT_EQ(classify(late_by(Nanoseconds(0))), MissCause::None);
  EXPECT_EQ(classify(late_by(Nanoseconds(-5))), MissCause::None);
  EXPECT_EQ(classify(late_by(milliseconds(1))), MissCause::Forecast);

  LatenessFacts infeasible = late_by(milliseconds(1));
  infeasible.mandatory = milliseconds(17);
  infeasible.off_cpu = milliseconds(9);
  EXPECT_EQ(classify(infeasible), MissCause::Infeasible);

  LatenessFacts machine = late_by(milliseconds(1));
  machine.off_cpu = milliseconds(1);
  machine.longest_overrun = milliseconds(2);
  EXPECT_EQ(classify(machine), MissCause::Machine);

  LatenessFacts overrun = late_by(milliseconds(1));
  overrun.off_cpu = microseconds(999);
  overrun.longest_overrun = milliseconds(1);
  EXPECT_EQ(classify(overrun), MissCause::Overrun);
}

}  // namespace
}  // namespace poise::scheduler
