// SPDX-License-Identifier: MIT
#include "solver/island_solver.h"

#include <gtest/gtest.h>

#include "solver/contact_bench.h"
#include "solver/iterations/settling.h"

namespace poise::solver {
namespace {

constexpr Stopping kConverged{1e-10, 1U << 16U, 0};

// Columns of boxes on one floor, and a box that falls.
void columns(Bench& bench) {
  bench.settings.gravity_mps2 = Vec3(0, 0, -9.81);
  bench.settings.stopping = kConverged;
  const auto floor = bench.add_body(0);
  for (int column = 0; column < 5; ++column) {
    auto below = floor;
    for (int i = 0; i <= column; ++i) {
      const double z_m = i;
      const Vec3 middle_m(3.0 * column, 0, z_m);
      const auto box = bench.add_body(1 + i, middle_m + Vec3(0, 0, 0.5), Vec3(0.3, 0.1 * i, 0));
      std::vector<Vec3> points_m;
      for (const double x : {-0.4, 0.4}) {
        for (const double y : {-0.4, 0.4}) points_m.emplace_back(middle_m + Vec3(x, y, 0));
      }
      bench.add_pair(below, box, Vec3(0, 0, 1), points_m, 0.5);
      below = box;
    }
  }
  bench.add_body(2, Vec3(0, 50, 9), Vec3(0, 1, 0));
}

double farthest_mps(const Bench& a, const Bench& b) {
  double farthest = 0;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    farthest = std::max({farthest, (a.bodies[i].velocity_mps - b.bodies[i].velocity_mps).norm(),
                         (a.bodies[i].spin_radps - b.bodies[i].spin_radps).norm(),
                         (a.bodies[i].moved_m - b.bodies[i].moved_m).norm()});
  }
  return farthest;
}

TEST(IslandSolver, FindsWhatAllIslandsTogetherFind) {
  Bench together;
  columns(together);
  EXPECT_TRUE(together.solve().reached);
  Bench apart;
  columns(apart);
  IslandSolver solver;
  const Convergence ended = solver.solve(apart.system(), apart.settings, *apart.executor);
  EXPECT_TRUE(ended.reached);
  EXPECT_LT(farthest_mps(together, apart), 1e-7);
  for (std::size_t p = 0; p < apart.pairs.size(); ++p)
    EXPECT_LT((apart.applied_impulse_ns[p] - together.applied_impulse_ns[p]).norm(), 1e-6) << p;
  EXPECT_NEAR(apart.bodies.back().velocity_mps.z(), -9.81 / 60, 1e-12) << "what touches nothing falls";
  EXPECT_EQ(apart.bodies.front().moved_m, Vec3::Zero());
}

TEST(IslandSolver, EachIslandEndsByItself) {
  Bench low;
  columns(low);
  Bench high;
  columns(high);
  IslandSolver solver;
  const Convergence all = solver.solve(low.system(), low.settings, *low.executor);
  const Convergence together = high.solve();
  EXPECT_LT(all.point_iterations, together.point_iterations) << "a box on the floor waits for no column";
}

TEST(IslandSolver, GivesTheSameBitsOnAnyNumberOfThreads) {
  Bench one;
  columns(one);
  IslandSolver first;
  first.solve(one.system(), one.settings, *one.executor);
  Bench three;
  columns(three);
  three.executor = parallel::make_executor(ExecutorKind::Threads, 3);
  IslandSolver second;
  second.solve(three.system(), three.settings, *three.executor);
  EXPECT_EQ(farthest_mps(one, three), 0);
}

TEST(IslandSolver, ABudgetOfIterationsThatRunsOutIsTold) {
  Bench bench;
  columns(bench);
  bench.settings.stopping.max_iterations = 3;
  IslandSolver solver;
  EXPECT_FALSE(solver.solve(bench.system(), bench.settings, *bench.executor).reached);
}

TEST(Settling, EndsOnceVelocitiesHaveSettledThoughImpulsesHaveNot) {
  Bench exact;
  stack(exact, 8);
  exact.settings.stopping = {1e-13, 1U << 15U, 0};
  const Convergence all = exact.solve();
  Bench settled;
  stack(settled, 8);
  settled.settings.stopping = {1e-13, 1U << 15U, 1e-2};
  const Convergence ended = settled.solve();
  EXPECT_TRUE(ended.reached);
  EXPECT_GE(ended.iterations, 2 * Settling::kFirst);
  EXPECT_LT(ended.iterations, all.iterations);
  for (const SolverBody& body : settled.bodies) EXPECT_LT(body.velocity_mps.norm(), 2e-2 * 9.81 / 60);
}

}  // namespace
}  // namespace poise::solver
