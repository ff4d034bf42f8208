// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <numeric>

#include "frame/scenes.h"

namespace poise {
namespace {

struct Pile : Stage {
  static WorldSettings serial() {
    WorldSettings settings;
    settings.gravity_mps2 = Vec3(0, 0, -9.81);
    settings.executor = ExecutorKind::Serial;
    return settings;
  }
  Pile() : Stage(serial(), 0.2) {
    jacks(40, 5);
    for (int i = 0; i < 40; ++i) world.step(step_of(1.0 / 60));
  }
  FrameReport look(const Budget& budget, const View& view = {}) {
    StepInput input = step_of(1.0 / 60);
    input.budget = budget;
    input.view = view;
    input.measure_levels = true;
    return world.step(input);
  }
};

TEST(LevelsReached, AreThereOnlyWhereTheyWereAskedFor) {
  Pile pile;
  EXPECT_FALSE(pile.world.step(step_of(1.0 / 60)).levels);
  EXPECT_TRUE(pile.look(Budget::unlimited()).levels);
}

TEST(LevelsReached, WithoutAViewWeighContactsAlikeAndCountEachBodyOnce) {
  Pile pile;
  const FrameReport report = pile.look(Budget::unlimited());
  ASSERT_GT(report.contact_pairs, 10U);
  const LevelsReached& levels = *report.levels;
  std::size_t bodies = 0;
  double weight = 0;
  for (std::size_t place = 0; place < levels.bodies.size(); ++place) {
    bodies += levels.bodies[place];
    weight += levels.weight[place];
    EXPECT_NEAR(levels.weight[place], scheduler::kDefaultPlainAngleRadpm * report.level_histogram[place], 1e-9)
        << place;
  }
  EXPECT_GT(bodies, 0U);
  EXPECT_LE(bodies, report.bodies);
  EXPECT_GT(weight, 0);
  EXPECT_EQ(levels.left_for_time, 0U);
  EXPECT_EQ(levels.longest_wait, 0U);
}

TEST(LevelsReached, CountPairsLeftForWantOfTimeAndForHowLong) {
  Pile pile;
  // No cached pair is valid, and nothing can be refined.
  std::uint32_t waited = 0;
  for (int i = 1; i <= 3; ++i) {
    for (const BodyId body : pile.bodies) {
      BodyState state = pile.at(body);
      state.position_m.z() += 1e-9;
      ASSERT_TRUE(pile.world.set_state(body, state).ok());
    }
    const FrameReport report = pile.look(Budget::work(0));
    EXPECT_EQ(report.levels->left_for_time, report.pairs_left);
    EXPECT_GT(report.levels->left_for_time, 0U);
    EXPECT_EQ(report.levels->left_for_capacity, 0U);
    EXPECT_GT(report.levels->longest_wait, waited);
    waited = report.levels->longest_wait;
  }
}

TEST(LevelsReached, WeighWhatIsNearTheViewerMore) {
  Pile pile;
  View near_by;
  near_by.present = true;
  near_by.position_m = Vec3(0, -5, 1);
  near_by.forward = near_by.gaze = Vec3::UnitY();
  View far_off = near_by;
  far_off.position_m = Vec3(0, -50, 1);
  const auto sum = [](const FrameReport& report) {
    return std::accumulate(report.levels->weight.begin(), report.levels->weight.end(), 0.0);
  };
  const double near_weight = sum(pile.look(Budget::unlimited(), near_by));
  EXPECT_GT(near_weight, 1.5 * sum(pile.look(Budget::unlimited(), far_off)));
}

}  // namespace
}  // namespace poise
