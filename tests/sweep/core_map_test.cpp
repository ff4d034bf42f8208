// SPDX-License-Identifier: MIT
#include "sweep/core_map.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace poise::testing {
namespace {

using sweep::CoreMap;
using Use = CoreMap::Use;
using Cores = std::vector<int>;

TEST(CoreMap, GivesTimedTrialsProcessorsThatNobodyElseHas) {
  CoreMap map({5, 2, 7, 3});
  const std::optional<Cores> first = map.take(2, Use::Alone);
  EXPECT_EQ(first, Cores({2, 3}));
  EXPECT_EQ(map.take(3, Use::Alone), std::nullopt);
  EXPECT_EQ(map.take(2, Use::Alone), Cores({5, 7}));
  EXPECT_EQ(map.take(1, Use::Shared), std::nullopt) << "none of them is shared";
  map.give_back(*first);
  EXPECT_EQ(map.take(1, Use::Shared), Cores({2}));
  EXPECT_EQ(map.take(1, Use::Alone), Cores({3}));
}

TEST(CoreMap, LetsCountedWorkShareWhereItMay) {
  CoreMap map({0, 1});
  EXPECT_EQ(map.take(1, Use::Unused), Cores({0}));
  EXPECT_EQ(map.take(1, Use::Unused), Cores({1}));
  EXPECT_EQ(map.take(1, Use::Unused), std::nullopt);
  EXPECT_EQ(map.take(1, Use::Shared), Cores({0}));
  EXPECT_EQ(map.take(1, Use::Shared), Cores({1})) << "the one that fewer have";
  map.give_back({0});
  EXPECT_EQ(map.take(1, Use::Alone), std::nullopt) << "another one still has it";
  map.give_back({0});
  EXPECT_EQ(map.take(1, Use::Alone), Cores({0}));
}

TEST(CoreMap, CountedWorkTakesAllWhereThereAreFewerThanItNeeds) {
  CoreMap map({0, 1});
  EXPECT_EQ(map.take(8, Use::Alone), std::nullopt);
  EXPECT_EQ(map.take(8, Use::Unused), Cores({0, 1}));
  EXPECT_EQ(map.take(8, Use::Shared), Cores({0, 1}));
}

}  // namespace
}  // namespace poise::testing
