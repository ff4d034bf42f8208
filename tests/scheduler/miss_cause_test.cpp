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

TEST(MissCause, AFrameThatBeganAsLateAsItEndedIsNotToBlame) {
  // 0.07 ms of work, released 15.5 ms late: what was left of its period was too short, the period was not.
  LatenessFacts late = late_by(microseconds(300));
  late.mandatory = microseconds(70);
  late.release_delay = microseconds(15500);
  EXPECT_EQ(classify(late), MissCause::Release);
  late.lateness = late.release_delay;
  EXPECT_EQ(classify(late), MissCause::Release);
  late.lateness = Nanoseconds(0);
  EXPECT_EQ(classify(late), MissCause::None);
}

TEST(MissCause, AFrameIsJudgedByWhatItWasLateBeyondItsDelay) {
  LatenessFacts late = late_by(milliseconds(5));
  late.release_delay = milliseconds(3);
  EXPECT_EQ(classify(late), MissCause::Forecast);
  late.longest_overrun = milliseconds(2);
  EXPECT_EQ(classify(late), MissCause::Overrun);
  late.off_cpu = milliseconds(2);
  EXPECT_EQ(classify(late), MissCause::Machine);
  late.mandatory = milliseconds(17);
  EXPECT_EQ(classify(late), MissCause::Infeasible) << "it would not have fitted into a whole period either";
}

TEST(MissCause, AnOverrunIsTheMachinesIfThatTookTheLargerPartOfIt) {
  LatenessFacts late = late_by(milliseconds(4));
  late.off_cpu = microseconds(3900);
  late.longest_overrun = microseconds(300);
  late.overrun_off_cpu = microseconds(3800);
  EXPECT_EQ(classify(late), MissCause::Machine);
  late.longest_overrun = microseconds(3800);
  late.overrun_off_cpu = microseconds(300);
  EXPECT_EQ(classify(late), MissCause::Overrun);
  late.longest_overrun = microseconds(100);
  late.overrun_off_cpu = microseconds(3800);
  EXPECT_EQ(classify(late), MissCause::Forecast) << "refinement alone did not make it late";
}

}  // namespace
}  // namespace poise::scheduler
