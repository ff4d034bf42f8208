// SPDX-License-Identifier: MIT
#include "world/learned_gains.h"

#include <gtest/gtest.h>

#include <vector>

#include "frame/refine/learned_chain.h"
#include "frame/scenes.h"

namespace poise::simulation {
namespace {

GainObservation refined(std::uint32_t level, bool apart, float change_m = 0) {
  GainObservation seen;
  seen.shape_low = 2;
  seen.shape_high = 5;
  seen.level = level;
  seen.apart = apart ? 1 : 0;
  seen.anew = 1;
  seen.change_m = change_m;
  return seen;
}

GainObservation lived(bool expired, float hazard) {
  GainObservation seen;
  seen.shape_low = 2;
  seen.shape_high = 5;
  seen.life = expired ? GainObservation::Life::Expired : GainObservation::Life::Valid;
  seen.life_level = 2;
  seen.hazard = hazard;
  return seen;
}

LearnedGains after(const GainObservation& seen, int times) {
  LearnedGains learned;
  for (int i = 0; i < times; ++i) {
    learned.observed().push_back(seen);
    learned.learn();
  }
  return learned;
}

ExpectedLevels expected_of(const LearnedGains& learned, double learning = 1, double hazard = 0.25) {
  ExpectedLevels expected;
  expected.error_m = {0.4F, 0.2F, 0.1F};
  scheduler::Policy policy;
  policy.learning = learning;
  expect_as_learned(learned.find(2, 5), policy, hazard, 2, expected);
  return expected;
}

TEST(LearnedGains, BeginAsTheProtrusionsSay) {
  const ExpectedLevels expected = expected_of(LearnedGains{});
  EXPECT_FLOAT_EQ(expected.error_m[0], 0.4F);
  EXPECT_FLOAT_EQ(expected.error_m[1], 0.2F);
  EXPECT_FLOAT_EQ(expected.error_m[2], 0.1F);
  EXPECT_FLOAT_EQ(expected.ended[1], 0.5F);
  EXPECT_FLOAT_EQ(expected.ended[2], 0.5F);
  EXPECT_FLOAT_EQ(expected.lifetime_frames[2], 4) << "as the motion says";
}

TEST(LearnedGains, CountForNothingWhereNothingIsToBeLearned) {
  const ExpectedLevels expected = expected_of(after(refined(2, true, 3), 500), 0);
  EXPECT_FLOAT_EQ(expected.error_m[0], 0.4F);
  EXPECT_FLOAT_EQ(expected.ended[2], 0.5F);
  EXPECT_FLOAT_EQ(expected.lifetime_frames[2], 1);
}

TEST(LearnedGains, ComeToWhatWasSeen) {
  const ExpectedLevels expected = expected_of(after(refined(2, true, 0.3F), 4000));
  // Half of the fall is the chance of ending, which the score multiplies by again.
  EXPECT_NEAR(0.5 * static_cast<double>(expected.error_m[0] - expected.error_m[2]), 0.3, 0.003);
  EXPECT_NEAR(static_cast<double>(expected.ended[1]), 0.0, 0.01) << "level 1 ended nothing";
  EXPECT_NEAR(static_cast<double>(expected.ended[2]), 1.0, 0.01);
}

TEST(LearnedGains, ALifetimeIsThatOfTheMotionTimesWhatWasSeen) {
  EXPECT_NEAR(static_cast<double>(expected_of(after(lived(false, 0.25F), 4000)).lifetime_frames[2]), kMostLifetime,
              1e-6);
  EXPECT_NEAR(static_cast<double>(expected_of(after(lived(true, 0.25F), 4000)).lifetime_frames[2]), 1, 0.02);
  const ExpectedLevels of_others = expected_of(after(lived(true, 0.25F), 4000));
  EXPECT_FLOAT_EQ(of_others.lifetime_frames[1], 4) << "nothing was seen of level 1";
}

TEST(LearnedGains, WhatWasSeenCountsFromTheNextFrameOn) {
  LearnedGains learned;
  learned.observed().push_back(refined(1, true, 1));
  EXPECT_EQ(learned.find(2, 5), nullptr);
  EXPECT_FALSE(learned.empty());
  learned.learn();
  ASSERT_NE(learned.find(2, 5), nullptr);
  EXPECT_EQ(learned.find(2, 5)->level[1].ended, 1);
  EXPECT_EQ(learned.find(5, 2), nullptr);
}

TEST(LearnedGains, WhatWasLongAgoCountsLess) {
  const LearnedGains learned = after(refined(1, true), 100'000);
  EXPECT_LE(learned.find(2, 5)->level[1].refined, 4096);
  EXPECT_EQ(learned.find(2, 5)->level[1].refined, learned.find(2, 5)->level[1].ended);
}

TEST(LearnedGains, AFullTableLetsTheOthersShareAnEntry) {
  LearnedGains learned;
  constexpr std::uint32_t kMany = LearnedGains::kMostShapePairs + 500;
  for (std::uint32_t shape = 0; shape < kMany; ++shape) {
    GainObservation seen = refined(1, true);
    seen.shape_low = shape;
    seen.shape_high = shape + 1;
    learned.observed().push_back(seen);
  }
  learned.learn();
  EXPECT_EQ(learned.entries().size(), LearnedGains::kMostShapePairs + 1);
  EXPECT_EQ(learned.find(3, 4)->level[1].refined, 1);
  EXPECT_EQ(learned.find(kMany - 1, kMany)->level[1].refined, 500);
  EXPECT_EQ(learned.find(7, 7777777)->level[1].refined, 500) << "of two shapes that nothing was seen of";
}

struct LearningRun {
  std::vector<std::uint64_t> hashes;
  std::vector<FrameDecisions> decisions;
};

LearningRun run_of(double learning, int threads, const Budget& budget,
                   const std::vector<FrameDecisions>* replay = nullptr) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.policy.learning = learning;
  settings.policy.onset = learning;
  settings.threads = threads;
  settings.executor = ExecutorKind::Threads;
  Stage stage(settings, 0.2);
  stage.jacks(60, 4.0);
  StepInput input = step_of(1.0 / 60);
  input.budget = budget;
  input.record = replay == nullptr;
  LearningRun made;
  for (std::size_t frame = 0; frame < 50; ++frame) {
    if (replay != nullptr) input.replay = &(*replay)[frame];
    EXPECT_EQ(stage.world.step(input).status, StepStatus::Done);
    made.hashes.push_back(stage.world.state_hash());
    made.decisions.emplace_back();
    stage.world.decisions(made.decisions.back());
  }
  return made;
}

TEST(Learning, IsTheSameOnAnyThreadsAndInAReplayWithAnotherPolicy) {
  const LearningRun recorded = run_of(1, 1, Budget::work(40));
  EXPECT_EQ(run_of(1, 3, Budget::work(40)).hashes, recorded.hashes);
  EXPECT_EQ(run_of(0, 2, Budget::unlimited(), &recorded.decisions).hashes, recorded.hashes);
}

TEST(Learning, OfAWallClockRunIsReplayedToTheBit) {
  const LearningRun recorded = run_of(1, 2, Budget::within(std::chrono::milliseconds(1)));
  EXPECT_EQ(run_of(1, 1, Budget::unlimited(), &recorded.decisions).hashes, recorded.hashes);
}

TEST(Learning, ChangesWhatIsRefinedAndIsPartOfTheState) {
  EXPECT_NE(run_of(1, 1, Budget::work(40)).hashes.back(), run_of(0, 1, Budget::work(40)).hashes.back());
}

TEST(Learning, LeavesStepsWithoutABudgetAsTheyAre) {
  EXPECT_EQ(run_of(1, 1, Budget::unlimited()).hashes, run_of(0, 1, Budget::unlimited()).hashes);
}

}  // namespace
}  // namespace poise::simulation
