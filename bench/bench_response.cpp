// SPDX-License-Identifier: MIT
// The response of a block of balls on a floor: nanoseconds a contact, without colouring.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "latencies.h"
#include "solver/contact_solver.h"
#include "solver/solver.h"

namespace poise::solver {
namespace {

/// side x side x 5 balls in a cubic grid, resting on static ground in slot 0.
struct Block {
  std::vector<SolverBody> bodies;
  std::vector<Acceleration> accelerations;
  std::vector<Mat3> inverse_inertia;
  std::vector<Edge> edges;
  std::vector<Vec3> directions;
  std::vector<ContactRow> rows;
  Coloring coloring;
  SolveScratch scratch;
  std::vector<Manifold> pairs;
  std::vector<ContactPoint> points;
  std::vector<ContactForce> forces;
  std::vector<Vec3> applied_impulse_ns;
  std::vector<collision::Pose> poses;
  ContactSolver solver;

  explicit Block(std::uint32_t side) {
    bodies.emplace_back();
    poses.emplace_back();
    accelerations = {{}, {Vec3(0, 0, -9.81), Vec3::Zero()}};
    const auto slot = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) { return 1 + x + side * (y + side * z); };
    for (std::uint32_t z = 0; z < 5; ++z) {
      for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
          bodies.emplace_back().inverse_mass = 1;
          bodies.back().acceleration = 1;
          poses.push_back({Vec3(x, y, z), Mat3::Identity()});
          if (x > 0) connect(slot(x - 1, y, z), slot(x, y, z), Vec3::UnitX());
          if (y > 0) connect(slot(x, y - 1, z), slot(x, y, z), Vec3::UnitY());
          connect(z > 0 ? slot(x, y, z - 1) : 0, slot(x, y, z), Vec3::UnitZ());
        }
      }
    }
    inverse_inertia.assign(bodies.size(), Mat3::Identity());
    coloring.color(edges, bodies.size());
    for (const std::uint32_t i : coloring.order()) {
      ContactRow row;
      row.a = edges[i].a;
      row.b = edges[i].b;
      row.wrench.direction = directions[i];
      prepare_wrench(bodies[row.a].inverse_mass, Mat3::Identity(), 1, Mat3::Identity(), row.wrench, row.turns);
      rows.push_back(row);
    }
    for (std::size_t i = 0; i < edges.size(); ++i) {
      Manifold& pair = pairs.emplace_back();
      pair.a = edges[i].a;
      pair.b = edges[i].b;
      pair.point_begin = static_cast<std::uint32_t>(i);
      pair.point_count = 1;
      const Vec3 on_b = -0.5 * directions[i];
      points.push_back(
          {directions[i], directions[i].dot(on_b), poses[pair.b].position_m + on_b - poses[pair.a].position_m, 0});
    }
    forces.resize(points.size());
    applied_impulse_ns.resize(pairs.size());
  }
  void connect(std::uint32_t a, std::uint32_t b, const Vec3& direction) {
    edges.push_back({a, b, a != 0, true, 1});
    directions.push_back(direction);
  }
  System system() { return {bodies, rows, {}, {}, inverse_inertia, coloring, scratch}; }
};

void step(Block& block, parallel::Executor& executor) {
  const SolveSettings settings{1.0 / 60, Vec3(0, 0, -9.81), 2, {}};
  solve_impacts(block.system(), settings, executor);
  block.solver.solve({block.bodies, block.accelerations, block.inverse_inertia, block.poses, block.pairs, block.points,
                      block.forces, block.applied_impulse_ns, block.coloring},
                     settings, executor);
  for (SolverBody& body : block.bodies) body.moved_m = body.turned_rad = Vec3::Zero();
}

void rest(benchmark::State& state) {
  const auto executor = parallel::make_executor(ExecutorKind::Tbb, static_cast<int>(state.range(1)));
  Block block(static_cast<std::uint32_t>(state.range(0)));
  for (int i = 0; i < 200; ++i) step(block, *executor);
  double fastest = 0;
  for (const SolverBody& body : block.bodies) fastest = std::max(fastest, body.velocity_mps.norm());
  if (!(fastest < 0.02)) state.SkipWithError("the block does not rest");
  bench::Latencies latencies;
  for (auto _ : state) latencies.time(state, [&] { step(block, *executor); });
  latencies.report(state);
  state.counters["s_per_contact"] =
      benchmark::Counter(static_cast<double>(block.rows.size()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(rest)
    ->ArgNames({"side", "threads"})
    ->ArgsProduct({{20, 63}, {1, 2}})
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

void coloring(benchmark::State& state) {
  Block block(static_cast<std::uint32_t>(state.range(0)));
  for (auto _ : state) {
    block.coloring.color(block.edges, block.bodies.size());
    benchmark::DoNotOptimize(block.coloring.order().data());
  }
  if (block.coloring.shared_begin() != block.edges.size()) state.SkipWithError("colours ran out");
  state.counters["s_per_contact"] =
      benchmark::Counter(static_cast<double>(block.rows.size()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(coloring)->ArgName("side")->Arg(63)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace poise::solver
