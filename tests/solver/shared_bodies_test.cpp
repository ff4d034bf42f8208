// SPDX-License-Identifier: MIT
#include "solver/shared_bodies.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "solver/contact_bench.h"
#include "solver/island_solver.h"

namespace poise::solver {
namespace {

constexpr double kGravity = 9.81;
constexpr double kSlabKg = 700;

// A slab on a square of balls on the ground, each of which touches both: the slab has as many pairs as there are balls.
struct Slab : Bench {
  std::uint32_t ground = 0, slab = 0;

  explicit Slab(int side, int threads = 1) {
    executor = parallel::make_executor(ExecutorKind::Threads, threads);
    settings.gravity_mps2 = Vec3(0, 0, -kGravity);
    ground = add_body(0);
    slab = add_body(kSlabKg, Vec3(0, 0, 1.2));
    inverse_inertia[slab] = Mat3::Identity() / (kSlabKg * side * side / 12.0);
    for (int i = 0; i < side * side; ++i) {
      const double x = i % side - 0.5 * (side - 1);
      const double y = static_cast<double>(i / side) - 0.5 * (side - 1);
      const auto ball = add_body(1, Vec3(x, y, 0.5));
      add_pair(ground, ball, Vec3::UnitZ(), {Vec3(x, y, 0)}, 0.5);
      add_pair(ball, slab, Vec3::UnitZ(), {Vec3(x, y, 1)}, 0.5);
    }
  }
  double load_on_ground_n() const {
    double sum = 0;
    for (const Manifold& pair : pairs) {
      if (pair.a == ground) sum += forces[pair.point_begin].normal_n;
    }
    return sum;
  }
};

// Few balls have their iterations extrapolated in double precision; many have a few plain ones a step.
class SharedSlab : public testing::TestWithParam<int> {};

TEST_P(SharedSlab, IsHeldByAllThatItStandsOn) {
  Slab bench(GetParam());
  for (int step = 0; step < 30; ++step) bench.solve();
  ASSERT_EQ(bench.coloring.shared().size(), 1U);
  ASSERT_EQ(bench.coloring.shared()[0].body, bench.slab);
  const double weight_n = kGravity * (kSlabKg + GetParam() * GetParam());
  EXPECT_NEAR(bench.load_on_ground_n(), weight_n, 1e-3 * weight_n);
  EXPECT_NEAR(bench.bodies[bench.slab].velocity_mps.z(), 0, 1e-4);
  EXPECT_NEAR(bench.bodies[bench.slab].moved_m.norm(), 0, 1e-5);
  EXPECT_LT(bench.bodies[bench.slab].spin_radps.norm(), 1e-4);
  EXPECT_TRUE(bench.bodies[bench.slab].solved);
  for (const SolverBody& body : bench.bodies) EXPECT_LT(body.velocity_mps.norm(), 1e-3);
}

TEST_P(SharedSlab, IsTheSameOnAnyNumberOfThreads) {
  Slab one(GetParam());
  Slab three(GetParam(), 3);
  for (int step = 0; step < 3; ++step) {
    one.solve();
    three.solve();
  }
  for (std::size_t i = 0; i < one.bodies.size(); ++i) {
    ASSERT_EQ(one.bodies[i].velocity_mps, three.bodies[i].velocity_mps);
    ASSERT_EQ(one.bodies[i].moved_m, three.bodies[i].moved_m);
  }
}

INSTANTIATE_TEST_SUITE_P(OnBalls, SharedSlab, testing::Values(12, 40));

TEST(SharedBodies, ConvergeInTheirIsland) {
  Slab bench(12);
  bench.settings.stopping = {1e-9, 1U << 14U, 0};
  IslandSolver solver;
  EXPECT_TRUE(solver.solve(bench.system(), bench.settings, *bench.executor).reached);
  EXPECT_NEAR(bench.load_on_ground_n(), kGravity * (kSlabKg + 144), 1e-2);
  EXPECT_LT(bench.bodies[bench.slab].velocity_mps.norm(), 1e-7);
}

TEST(SharedBodies, ThatNothingPushesStayAsTheyAreToTheBit) {
  Bench bench;
  const Vec3 velocity(0.1, -0.2, 0.3);
  const auto hub = bench.add_body(3, Vec3::Zero(), velocity);
  bench.bodies[hub].spin_radps = Vec3(0.7, 0.1, -0.3);
  for (int i = 0; i < 300; ++i) {
    const auto ball = bench.add_body(1, Vec3(3, 0, 0.01 * i));
    bench.add_pair(hub, ball, Vec3::UnitX(), {Vec3(1.5, 0, 0)}, 0.4, 1);
  }
  bench.solve();
  ASSERT_EQ(bench.coloring.shared().size(), 1U);
  EXPECT_EQ(bench.bodies[hub].velocity_mps, velocity);
  EXPECT_EQ(bench.bodies[hub].spin_radps, Vec3(0.7, 0.1, -0.3));
  EXPECT_FALSE(bench.bodies[hub].solved);
}

// Balls that fly at one in their middle, from all sides and each at its own speed.
TEST(SharedBodies, KeepMomentumAndAddNoEnergy) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const double hub_kg : {0.1, 10.0, 1e4}) {
    Bench bench;
    const auto hub = bench.add_body(hub_kg, Vec3::Zero(), Vec3(0.2, 0, 0));
    bench.bodies[hub].spin_radps = Vec3(0, 1, 0.5);
    for (int i = 0; i < 500; ++i) {
      const Vec3 out = Vec3(unit(random), unit(random), unit(random)).normalized();
      const auto ball = bench.add_body(1, 3 * out, -(1 + unit(random)) * out);
      bench.add_pair(hub, ball, out, {2 * out}, 0.4);
    }
    const Vec3 momentum = bench.momentum();
    const Vec3 angular = bench.angular_momentum();
    const double energy_j = bench.energy_j();
    bench.solve();
    ASSERT_EQ(bench.coloring.shared().size(), 1U);
    EXPECT_LT((bench.momentum() - momentum).norm(), 1e-10) << hub_kg;
    // Where it cannot be returned without adding energy, some is left, as of any pair.
    EXPECT_LT((bench.angular_momentum() - angular).norm(), 1e-3 * hub_kg) << hub_kg;
    EXPECT_LT(bench.energy_j(), energy_j) << hub_kg;
  }
}

}  // namespace
}  // namespace poise::solver
