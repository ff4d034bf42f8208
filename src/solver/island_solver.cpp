// SPDX-License-Identifier: MIT
#include "solver/island_solver.h"

#include <algorithm>
#include <numeric>

#include "parallel/disjoint_sets.h"

namespace poise::solver {
namespace {

constexpr std::uint32_t kNone = 0xffffffffU;
// Contact points from which on an island is worth all threads. Chosen: an iteration then takes tens of microseconds.
constexpr std::uint64_t kLargePoints = 2048;

bool is_dynamic(const ContactSystem& system, std::uint32_t body) { return system.bodies[body].inverse_mass > 0; }

}  // namespace

void IslandSolver::find_islands(const ContactSystem& system) {
  const std::size_t count = system.bodies.size();
  parent_.resize(count);
  std::iota(parent_.begin(), parent_.end(), 0U);
  parallel::DisjointSets sets(parent_);
  for (std::uint32_t p = 0; p < system.pairs.size(); ++p) {
    const Manifold& pair = system.pairs[p];
    if (system.solved_points(p) > 0 && is_dynamic(system, pair.a) && is_dynamic(system, pair.b))
      sets.unite(pair.a, pair.b);
  }
  islands_.clear();
  island_of_.assign(count, kNone);
  for (std::uint32_t p = 0; p < system.pairs.size(); ++p) {
    const Manifold& pair = system.pairs[p];
    const std::uint32_t dynamic = is_dynamic(system, pair.a) ? pair.a : pair.b;
    if (system.solved_points(p) == 0 || !is_dynamic(system, dynamic)) {
      system.applied_impulse_ns[p] = Vec3::Zero();
      continue;
    }
    std::uint32_t& of_root = island_of_[sets.root(dynamic)];
    if (of_root == kNone) {
      of_root = static_cast<std::uint32_t>(islands_.size());
      islands_.emplace_back();
    }
    islands_[of_root].pairs.push_back(p);
    islands_[of_root].points += pair.point_count;
  }
  local_.resize(count);
  Island alone;
  for (std::uint32_t body = 0; body < count; ++body) {
    // What is not dynamic is not moved by a solve, and islands on other threads copy it meanwhile.
    if (!is_dynamic(system, body)) continue;
    const std::uint32_t of_root = island_of_[sets.root(body)];
    Island& island = of_root == kNone ? alone : islands_[of_root];
    local_[body] = static_cast<std::uint32_t>(island.bodies.size());
    island.bodies.push_back(body);
  }
  std::stable_sort(islands_.begin(), islands_.end(),
                   [](const Island& a, const Island& b) { return a.points > b.points; });
  islands_.push_back(std::move(alone));
}

Convergence IslandSolver::solve_one(const ContactSystem& system, const Island& island, const SolveSettings& settings,
                                    Worker& worker, parallel::Executor& executor) const {
  worker.bodies.clear();
  worker.inverse_inertia.clear();
  worker.poses.clear();
  const auto copy = [&](std::uint32_t body) {
    worker.bodies.push_back(system.bodies[body]);
    worker.inverse_inertia.push_back(system.inverse_inertia[body]);
    worker.poses.push_back(system.poses[body]);
    return static_cast<std::uint32_t>(worker.bodies.size() - 1);
  };
  for (const std::uint32_t body : island.bodies) copy(body);
  worker.pairs.clear();
  worker.edges.clear();
  for (const std::uint32_t p : island.pairs) {
    Manifold pair = system.pairs[p];
    const bool dynamic_a = is_dynamic(system, pair.a);
    const bool dynamic_b = is_dynamic(system, pair.b);
    pair.a = dynamic_a ? local_[pair.a] : copy(pair.a);
    pair.b = dynamic_b ? local_[pair.b] : copy(pair.b);
    worker.pairs.push_back(pair);
    worker.edges.push_back({pair.a, pair.b, dynamic_a, dynamic_b, rank_of(pair.point_count)});
  }
  worker.applied_impulse_ns.resize(worker.pairs.size());
  worker.coloring.color(worker.edges, worker.bodies.size());
  const Convergence ended =
      worker.solver.solve({worker.bodies, system.accelerations, worker.inverse_inertia, worker.poses, worker.pairs,
                           system.points, system.forces, worker.applied_impulse_ns, worker.coloring, island.points},
                          settings, executor);
  for (std::size_t i = 0; i < island.bodies.size(); ++i) system.bodies[island.bodies[i]] = worker.bodies[i];
  for (std::size_t k = 0; k < island.pairs.size(); ++k)
    system.applied_impulse_ns[island.pairs[k]] = worker.applied_impulse_ns[k];
  return ended;
}

Convergence IslandSolver::solve(const ContactSystem& system, const SolveSettings& settings,
                                parallel::Executor& executor) {
  find_islands(system);
  while (workers_.size() < static_cast<std::size_t>(executor.concurrency())) {
    workers_.emplace_back();
    workers_.back().serial = parallel::make_executor(ExecutorKind::Serial, 1);
  }
  std::vector<Convergence> ended(islands_.size());
  std::size_t large = 0;
  for (; large < islands_.size() && islands_[large].points >= kLargePoints; ++large)
    ended[large] = solve_one(system, islands_[large], settings, workers_[0], executor);
  parallel::parallel_for(executor, islands_.size() - large, 1, [&](std::size_t i, std::size_t, int worker) {
    Worker& own = workers_[static_cast<std::size_t>(worker)];
    ended[large + i] = solve_one(system, islands_[large + i], settings, own, *own.serial);
  });
  Convergence all;
  for (const Convergence& one : ended) {
    all.reached = all.reached && one.reached;
    all.iterations = std::max(all.iterations, one.iterations);
    all.point_iterations += one.point_iterations;
  }
  return all;
}

}  // namespace poise::solver
