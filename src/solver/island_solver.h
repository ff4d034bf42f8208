// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "solver/contact_solver.h"

namespace poise::solver {

/// Resting contact, island by island: what no contacts connect is solved apart, small islands side by side on all
/// threads, and an island ends when it has converged itself. For iterations that converge (Stopping): elsewhere the
/// limits of the iterations depend on what is solved together. Invariant: buffers only grow.
class IslandSolver {
 public:
  /// As ContactSolver::solve. `reached` if all islands have; `iterations` are the most that an island made. The same
  /// bits on any number of threads.
  Convergence solve(const ContactSystem& system, const SolveSettings& settings, parallel::Executor& executor);

 private:
  // An island with copies of its bodies, numbered anew; what is not dynamic has a copy for each pair.
  struct Island {
    std::vector<std::uint32_t> bodies;  // by their numbers in the system
    std::vector<std::uint32_t> pairs;   // likewise
    std::uint64_t points = 0;
  };
  // What a worker works in.
  struct Worker {
    std::unique_ptr<parallel::Executor> serial;
    ContactSolver solver;
    Coloring coloring;
    std::vector<Edge> edges;
    std::vector<SolverBody> bodies;
    std::vector<Mat3> inverse_inertia;
    std::vector<collision::Pose> poses;
    std::vector<Manifold> pairs;
    std::vector<Vec3> applied_impulse_ns;
  };

  void find_islands(const ContactSystem& system);
  Convergence solve_one(const ContactSystem& system, const Island& island, const SolveSettings& settings,
                        Worker& worker, parallel::Executor& executor) const;

  std::vector<std::uint32_t> parent_, local_, island_of_;  // one a body
  std::vector<Island> islands_;                            // the largest first; the last is of bodies without pairs
  std::vector<Worker> workers_;
};

}  // namespace poise::solver
