// SPDX-License-Identifier: MIT
#include "solver/impacts/impact_row.h"

#include <gtest/gtest.h>

namespace poise::solver {
namespace {

TEST(ContactRow, EffectiveMassOfTwoPointMassesIsTheReducedMass) {
  Wrench wrench{Vec3::UnitX()};
  Turns turns;
  ASSERT_TRUE(prepare_wrench(0.5, Mat3::Zero(), 0.25, Mat3::Zero(), wrench, turns));
  EXPECT_DOUBLE_EQ(wrench.effective_mass, 1 / 0.75);
}

TEST(ContactRow, OpposedNormalsThatCancelAreDegenerateAndAnswerNothing) {
  Wrench wrench;
  Turns turns;
  EXPECT_FALSE(prepare_wrench(1, Mat3::Identity(), 1, Mat3::Identity(), wrench, turns));
  EXPECT_EQ(wrench.effective_mass, 0);
}

}  // namespace
}  // namespace poise::solver
