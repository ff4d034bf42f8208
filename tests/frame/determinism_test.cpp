// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <thread>

#include "frame/scenes.h"

namespace poise {
namespace {

WorldSettings falling(ExecutorKind executor, int threads, scheduler::PolicyKind policy, ContactModel model) {
  WorldSettings settings;
  settings.gravity_mps2 = Vec3(0, 0, -9.81);
  settings.executor = executor;
  settings.threads = threads;
  settings.policy.kind = policy;
  settings.contact = model;
  return settings;
}

std::uint64_t hash_after(const WorldSettings& settings, const Budget& budget, int frames = 90) {
  Stage stage(settings, 0.2);
  stage.jacks(120, 5.2);
  StepInput input = step_of(1.0 / 60);
  input.budget = budget;
  input.view = {true, Vec3(8, -8, 5), Vec3(-1, 1, -0.5).normalized(), Vec3::UnitZ(),
                0.87, 1.78,           Vec3(-1, 1, -0.5).normalized()};
  std::size_t refined = 0;
  for (int i = 0; i < frames; ++i) refined += stage.world.step(input).jobs_done;
  EXPECT_GT(refined, 100U);
  return stage.world.state_hash();
}

TEST(Determinism, TheSameWorkBudgetGivesTheSameBitsOnAnyThreadsAndExecutor) {
  using scheduler::PolicyKind;
  for (const PolicyKind policy : {PolicyKind::Perceptual, PolicyKind::Fifo, PolicyKind::Random}) {
    for (const ContactModel model : {ContactModel::Wrench, ContactModel::Paper, ContactModel::Fitted}) {
      const std::uint64_t expected = hash_after(falling(ExecutorKind::Serial, 1, policy, model), Budget::work(400));
      for (const int threads : {1, 3, 8}) {
        for (const ExecutorKind executor : {ExecutorKind::Tbb, ExecutorKind::Threads}) {
          EXPECT_EQ(hash_after(falling(executor, threads, policy, model), Budget::work(400)), expected)
              << threads << " threads";
        }
      }
    }
  }
}

TEST(Determinism, PoliciesBudgetsAndSeedsMakeADifference) {
  using scheduler::PolicyKind;
  const auto hash = [](PolicyKind policy, std::uint64_t budget, std::uint64_t seed) {
    WorldSettings settings = falling(ExecutorKind::Serial, 1, policy, ContactModel::Wrench);
    settings.seed = seed;
    return hash_after(settings, Budget::work(budget));
  };
  const std::uint64_t plain = hash(PolicyKind::Perceptual, 400, 1);
  EXPECT_EQ(hash(PolicyKind::Perceptual, 400, 2), plain) << "only the random policy draws";
  EXPECT_NE(hash(PolicyKind::Perceptual, 300, 1), plain);
  EXPECT_NE(hash(PolicyKind::Fifo, 400, 1), plain);
  EXPECT_NE(hash(PolicyKind::Random, 400, 1), hash(PolicyKind::Random, 400, 2));
}

TEST(Determinism, AnUnlimitedBudgetIsTheSameAsOneThatIsNeverUsedUp) {
  const WorldSettings settings =
      falling(ExecutorKind::Threads, 3, scheduler::PolicyKind::Perceptual, ContactModel::Wrench);
  EXPECT_EQ(hash_after(settings, Budget::unlimited()), hash_after(settings, Budget::work(1U << 30U)));
}

TEST(Determinism, SeveralWorldsStepAtOnceWithoutASign) {
  const WorldSettings settings =
      falling(ExecutorKind::Threads, 2, scheduler::PolicyKind::Perceptual, ContactModel::Wrench);
  const std::uint64_t expected = hash_after(settings, Budget::work(500));
  std::uint64_t hashes[3] = {};
  std::vector<std::thread> threads;
  for (std::uint64_t& hash : hashes) {
    threads.emplace_back([&hash, &settings] { hash = hash_after(settings, Budget::work(500)); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, expected);
}

TEST(Determinism, EveryPartOfTheStateIsInTheHash) {
  Stage stage({});
  const BodyId ball = stage.add(stage.ball(0.5), Vec3(1, 2, 3));
  std::vector<std::uint64_t> hashes = {stage.world.state_hash()};
  BodyState state = stage.at(ball);
  state.position_m.x() = std::nextafter(1.0, 2.0);
  ASSERT_TRUE(stage.world.set_state(ball, state).ok());
  hashes.push_back(stage.world.state_hash());
  ASSERT_TRUE(stage.world.apply_force(ball, Vec3(1e-300, 0, 0), state.position_m).ok());
  hashes.push_back(stage.world.state_hash());
  ASSERT_TRUE(stage.world.set_importance(ball, 2).ok());
  hashes.push_back(stage.world.state_hash());
  stage.world.step(step_of(0.01));
  hashes.push_back(stage.world.state_hash());
  for (std::size_t i = 1; i < hashes.size(); ++i) EXPECT_NE(hashes[i], hashes[i - 1]);
}

// Without a limit each pair is refined to its end on its own; a sufficient budget gives the same result in rounds.
TEST(Determinism, NoLimitIsWhatAnyBudgetThatSufficesComesTo) {
  for (const ContactModel model : {ContactModel::Wrench, ContactModel::Fitted}) {
    std::array<std::uint64_t, 2> hashes{};
    for (const bool limited : {false, true}) {
      WorldSettings settings;
      settings.gravity_mps2 = Vec3(0, 0, -9.81);
      settings.contact = model;
      settings.threads = limited ? 1 : 2;
      Stage stage(settings, 0.2);
      stage.jacks(40, 4);
      for (int i = 0; i < 90; ++i) {
        StepInput input = step_of(1.0 / 60);
        if (limited) input.budget = Budget::work(1'000'000'000);
        EXPECT_EQ(stage.world.step(input).pairs_left, 0U);
      }
      hashes[limited ? 1 : 0] = stage.world.state_hash();
    }
    EXPECT_EQ(hashes[0], hashes[1]);
  }
}

}  // namespace
}  // namespace poise
