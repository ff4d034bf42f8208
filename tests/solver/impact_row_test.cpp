// SPDX-License-Identifier: MIT
#include "solver/impact_row.h"

#include <gtest/gtest.h>

namespace poise::solver {
namespace {

TEST(ContactRow, EffectiveMassOfTwoPointMassesIsTheReducedMass) {
  ContactRow row;
  row.direction = Vec3::UnitX();
  ASSERT_TRUE(prepare_row(row, 0.5, Mat3::Zero(), 0.25, Mat3::Zero()));
  EXPECT_DOUBLE_EQ(row.effective_mass, 1 / 0.75);
}

TEST(ContactRow, OpposedNormalsThatCancelAreDegenerateAndAnswerNothing) {
  ContactRow row;
  EXPECT_FALSE(prepare_row(row, 1, Mat3::Identity(), 1, Mat3::Identity()));
  EXPECT_EQ(row.effective_mass, 0);
}

}  // namespace
}  // namespace poise::solver
