// SPDX-License-Identifier: MIT
#include "frame/pair_progress.h"

#include <gtest/gtest.h>

namespace poise::simulation {
namespace {

PairProgress pair_with(CacheUse cached, Level cached_level, Level deepest = 5) {
  PairProgress pair;
  pair.cached = cached;
  pair.cached_level = cached_level;
  pair.level.deepest = deepest;
  return pair;
}

TEST(PairProgress, BeginsWhereTheCacheSays) {
  EXPECT_EQ(pair_with(CacheUse::None, 3).state(), ContactState::Coarsest);
  EXPECT_EQ(pair_with(CacheUse::Separated, 3).state(), ContactState::CachedSeparated);
  EXPECT_EQ(pair_with(CacheUse::Points, 3).state(), ContactState::Cached);
  EXPECT_EQ(pair_with(CacheUse::Expired, 3).state(), ContactState::Cached);
  EXPECT_EQ(pair_with(CacheUse::Parted, 3).state(), ContactState::CachedSeparated);
}

TEST(PairProgress, ALevelReplacesTheCachedPointsOnceItIsAsDeep) {
  for (const CacheUse cached : {CacheUse::Points, CacheUse::Expired}) {
    PairProgress pair = pair_with(cached, 3);
    for (Level level = 1; level <= 5; ++level) {
      pair.level.level = level;
      EXPECT_EQ(pair.state(), level < 3 ? ContactState::Cached : ContactState::Refined) << int{level};
      EXPECT_EQ(pair.solved_level(), level < 3 ? 3 : level);
    }
  }
}

TEST(PairProgress, WhatHasPartedIsApartUntilALevelAsDeepFindsItNear) {
  PairProgress pair = pair_with(CacheUse::Parted, 3);
  for (Level level = 0; level <= 5; ++level) {
    pair.level.level = level;
    EXPECT_EQ(pair.apart(), level < 3) << int{level};
    EXPECT_EQ(pair.state(), level < 3 ? ContactState::CachedSeparated : ContactState::Refined) << int{level};
    EXPECT_EQ(pair.refinable(), level < 5) << int{level};
  }
}

TEST(PairProgress, NoNodesNearIsSeparatedAtAnyLevel) {
  for (const CacheUse cached : {CacheUse::None, CacheUse::Points, CacheUse::Expired, CacheUse::Parted}) {
    PairProgress pair = pair_with(cached, 3);
    pair.level.level = 1;
    pair.level.apart = true;
    EXPECT_EQ(pair.state(), ContactState::Separated);
    EXPECT_TRUE(pair.apart());
    EXPECT_FALSE(pair.refinable());
  }
}

TEST(PairProgress, BacktrackingMakesAnExactContactOrASeparatedPair) {
  PairProgress pair = pair_with(CacheUse::None, 0, 0);
  pair.exact = true;
  EXPECT_EQ(pair.state(), ContactState::Exact);
  EXPECT_FALSE(pair.refinable());
  pair.level.apart = true;
  EXPECT_EQ(pair.state(), ContactState::Separated);
}

TEST(PairProgress, IsRefinedWhileThereIsADeeperLevelThanTheSureOne) {
  EXPECT_TRUE(pair_with(CacheUse::None, 0).refinable());
  EXPECT_TRUE(pair_with(CacheUse::Points, 4).refinable());
  EXPECT_FALSE(pair_with(CacheUse::Points, 5).refinable());
  EXPECT_TRUE(pair_with(CacheUse::Expired, 5).refinable());
  EXPECT_FALSE(pair_with(CacheUse::Separated, 0).refinable());
}

TEST(PairOutcome, TellsWhyAPairWentNoFurther) {
  EXPECT_EQ(outcome_of(pair_with(CacheUse::Separated, 3)), PairOutcome::KnownApart);
  EXPECT_EQ(outcome_of(pair_with(CacheUse::Points, 5)), PairOutcome::KnownPoints);
  PairProgress pair = pair_with(CacheUse::None, 0);
  EXPECT_EQ(outcome_of(pair), PairOutcome::Unserved);
  pair.full = true;
  EXPECT_EQ(outcome_of(pair), PairOutcome::FrontFull);
  pair.level.level = 5;
  EXPECT_EQ(outcome_of(pair), PairOutcome::Deepest) << "whatever happened on the way";
  pair.level.apart = true;
  EXPECT_EQ(outcome_of(pair), PairOutcome::FoundApart);
  pair.exact = true;
  EXPECT_EQ(outcome_of(pair), PairOutcome::Mandatory);
  pair = pair_with(CacheUse::None, 0);
  pair.stop = Stop::Unseen;
  EXPECT_EQ(outcome_of(pair), PairOutcome::Unseen);
  pair.stop_for_time();
  EXPECT_EQ(outcome_of(pair), PairOutcome::CutOff);
}

TEST(PairOutcome, AReusedPairIsOneUntilItHasALevel) {
  PairProgress pair = pair_with(CacheUse::Expired, 3);
  pair.stop = Stop::Reused;
  pair.stop_for_time();
  EXPECT_EQ(outcome_of(pair), PairOutcome::Reused) << "its first level was begun, and it is used as it is cached";
  pair.level.level = 1;
  EXPECT_EQ(outcome_of(pair), PairOutcome::Unserved);
  pair.stop_for_time();
  EXPECT_EQ(outcome_of(pair), PairOutcome::CutOff);
}

}  // namespace
}  // namespace poise::simulation
