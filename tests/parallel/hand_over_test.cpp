// SPDX-License-Identifier: MIT
#include "parallel/hand_over.h"

#include <gtest/gtest.h>

#include <vector>

#include "parallel/background_thread.h"

namespace poise::parallel {
namespace {

TEST(HandOver, GivesValuesInOrderUpToItsCapacity) {
  HandOver<int> values(2);
  int value = 1;
  EXPECT_TRUE(values.give(value));
  value = 2;
  EXPECT_TRUE(values.has_room());
  EXPECT_TRUE(values.give(value));
  EXPECT_FALSE(values.has_room());
  value = 3;
  EXPECT_FALSE(values.give(value));
  EXPECT_EQ(value, 3) << "what is not handed over stays";
  int taken = 0;
  EXPECT_TRUE(values.take(taken));
  EXPECT_EQ(taken, 1);
  EXPECT_TRUE(values.give(value));
  EXPECT_TRUE(values.take(taken));
  EXPECT_EQ(taken, 2);
  EXPECT_TRUE(values.take(taken));
  EXPECT_EQ(taken, 3);
  EXPECT_FALSE(values.take(taken));
}

TEST(HandOver, GivesMemoryBackToBeUsedAgain) {
  HandOver<std::vector<int>> values(1);
  std::vector<int> taken(1000);
  std::vector<int> value{7};
  ASSERT_TRUE(values.give(value));
  ASSERT_TRUE(values.take(taken));
  EXPECT_EQ(taken, std::vector<int>{7});
  // Two slots take turns.
  ASSERT_TRUE(values.give(value));
  ASSERT_TRUE(values.take(taken));
  ASSERT_TRUE(values.give(value));
  EXPECT_GE(value.capacity(), 1000U);
}

TEST(HandOver, LosesNothingBetweenTwoThreads) {
  constexpr int kMany = 20'000;
  HandOver<int> values(3);
  std::vector<int> got;
  {
    const BackgroundThread taker([&] {
      for (int value = 0; got.size() < kMany;) {
        if (values.take(value)) got.push_back(value);
      }
    });
    for (int i = 0; i < kMany;) {
      int value = i;
      if (values.give(value)) ++i;
    }
  }
  ASSERT_EQ(got.size(), std::size_t{kMany});
  for (int i = 0; i < kMany; ++i) ASSERT_EQ(got[static_cast<std::size_t>(i)], i);
}

}  // namespace
}  // namespace poise::parallel
