// SPDX-License-Identifier: MIT
#include "solver/iterations/energy_guard.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <limits>
#include <vector>

namespace poise::solver {
namespace {

// A floor, two bodies whose pairs are in one block, and one that touches nothing.
struct Two {
  std::vector<SolverBody> bodies{4};
  std::vector<Acceleration> accelerations{4};
  std::vector<Mat3> inverse_inertia{4, Mat3::Zero()};
  Coloring coloring;
  SplitSystem system = {{bodies, accelerations, inverse_inertia, {}, {}, {}, {}, {}, coloring}, {}, {}, {}};
  std::array<ContactBlock, 1> blocks;
  std::vector<MotionChange<double>> changes{4};
  EnergyGuard energy;

  Two() {
    for (const std::size_t i : {1U, 2U, 3U}) {
      bodies[i].inverse_mass = 1.0 / static_cast<double>(2 * i);
      inverse_inertia[i] = Vec3(1, 0.5, 0.25).asDiagonal();
      bodies[i].acceleration = static_cast<std::uint32_t>(i);
      accelerations[i].linear_mps2 = Vec3(0, 0, -10);
    }
    bodies[1].velocity_mps = Vec3(3, 0, 0);
    bodies[2].spin_radps = Vec3(0, 2, 0);
    bodies[3].velocity_mps = Vec3(100, 0, 0);
    blocks[0].count = 2;
    blocks[0].a[0] = 1;
    blocks[0].b[0] = 0;
    blocks[0].a[1] = 1;
    blocks[0].b[1] = 2;
    energy.begin(system, blocks);
  }
};

TEST(EnergyGuard, CountsEachBodyThatTouchesOnceAndNoOther) {
  const Two two;
  EXPECT_DOUBLE_EQ(two.energy.joules(two.changes), 0.5 * 2 * 9 + 0.5 * 2 * 4) << "1 kg m^2 / 0.5 about y";
}

TEST(EnergyGuard, CountsChangesOnTopOfTheStart) {
  Two two;
  two.changes[1].v[0] = -3;
  two.changes[2].w[0] = 1;
  two.changes[3].v[1] = 7;
  EXPECT_DOUBLE_EQ(two.energy.joules(two.changes), 0.5 * 2 * 4 + 0.5 * 1 * 1);
}

TEST(EnergyGuard, AloneIsWithForcesAndWithoutContacts) {
  const Two two;
  const std::vector<SpeedChange<double>> begun(4);
  EXPECT_DOUBLE_EQ(two.energy.joules_alone(two.system, begun, 0.1), 0.5 * 2 * (9 + 1) + 0.5 * 2 * 4 + 0.5 * 4 * 1);
}

TEST(EnergyGuard, TheBestShareOfImpulsesStopsWhatMorePushesBack) {
  // Body 1 starts with 3 m/s along x; the impulses turn that into 1 m/s in the other direction.
  Two two;
  const std::vector<SpeedChange<double>> begun(4);
  for (Acceleration& pull : two.accelerations) pull.linear_mps2.setZero();
  two.changes[1].v[0] = -4;
  const double share = two.energy.best_share(two.system, begun, 0.1, two.changes);
  EXPECT_DOUBLE_EQ(share, 0.75);
  two.energy.scale(two.system, begun, 0.1, share, two.changes);
  EXPECT_DOUBLE_EQ(two.changes[1].v[0], -3);
  EXPECT_EQ(two.changes[3].v[0], 0) << "it touches nothing";
  two.changes[1].v[0] = -2;
  EXPECT_EQ(two.energy.best_share(two.system, begun, 0.1, two.changes), 1)
      << "less than that leaves nothing to take back";
  two.changes[1].v[0] = 2;
  EXPECT_EQ(two.energy.best_share(two.system, begun, 0.1, two.changes), 0) << "these only push on";
}

TEST(EnergyGuard, ScalingKeepsWhatForcesAdd) {
  Two two;
  std::vector<SpeedChange<double>> begun(4);
  begun[1].v[0] = 1;
  two.changes[1].v[0] = 5;
  two.changes[1].v[2] = 3;
  two.energy.scale(two.system, begun, 0.1, 0.5, two.changes);
  EXPECT_DOUBLE_EQ(two.changes[1].v[0], 3) << "1 without contacts, 5 with";
  EXPECT_DOUBLE_EQ(two.changes[1].v[2], 1) << "-1 without, 3 with";
}

TEST(EnergyGuard, BringsBackWhatWasToTheBit) {
  Two two;
  two.changes[1].v[2] = 0.1;
  two.changes[2].q[1] = 0.3;
  const std::vector<MotionChange<double>> were = two.changes;
  two.energy.keep(two.changes);
  two.changes[1].v[2] = std::numeric_limits<double>::infinity();
  two.changes[2].q[1] = std::numeric_limits<double>::quiet_NaN();
  two.energy.restore(two.changes);
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_EQ((std::bit_cast<std::array<std::uint64_t, 16>>(two.changes[i])),
              (std::bit_cast<std::array<std::uint64_t, 16>>(were[i])));
  }
}

}  // namespace
}  // namespace poise::solver
