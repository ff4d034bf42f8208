// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "parallel/executor.h"
#include "poise/types.h"
#include "solver/contact_point.h"
#include "solver/solver.h"

namespace poise::solver {

/// A pair that may rest: its places follow each other.
struct Manifold {
  std::uint32_t a = 0, b = 0;  ///< solver bodies
  std::uint32_t point_begin = 0;
  std::uint32_t pair = 0;        ///< the caller's name for it
  std::uint8_t point_count = 0;  ///< at most kMaxPatches of collision; 0: this step it does not rest
  bool fast = false;             ///< the caller's: it may have an impact
  double friction = 0;           ///< Coulomb's coefficient, >= 0
  double restitution = 0;  ///< a place that closes fast enough to rebound is left to the impact phase of a later step
  double slop_m = 0;       ///< overlap that is left alone
};

/// Bodies and pairs of one step. `coloring` is that of `pairs`, ranked by their places.
struct ContactSystem {
  std::span<SolverBody> bodies;
  std::span<const Acceleration> accelerations;  ///< one a body
  std::span<const Mat3> inverse_inertia;        ///< one a body, world frame
  std::span<const collision::Pose> poses;       ///< one a body
  std::span<const Manifold> pairs;
  std::span<const ContactPoint> points;
  std::span<AccumulatedImpulse>
      loads;  ///< one a place: what the last step ended with goes in, what this one ends with comes out
  std::span<Vec3> applied_impulse_ns;  ///< one a pair: comes out, what b received in the step
  const Coloring& coloring;
  std::uint64_t point_count = 0;  ///< of all pairs
};

/// Lanes of the solver: eight pairs of a colour side by side. Invariant: buffers only grow.
class ContactSolver {
 public:
  ContactSolver();
  ~ContactSolver();
  ContactSolver(ContactSolver&&) noexcept;
  ContactSolver& operator=(ContactSolver&&) noexcept;

  /// Adds forces and keeps bodies from sinking into each other (docs/response.md). In `substeps` (Macklin et al. 2019)
  /// place after place gets the impulse that keeps its gap from closing further than it is wide, warm started from the
  /// last step's, and Coulomb friction within its cone; what overlaps beyond doubt is pushed apart in place alone. A
  /// substep goes over its places until they settle, and visits at most settings.visits of them. Impulses are sought in
  /// single precision from what changes in the step, and given in double precision at the end: momentum and angular
  /// momentum are kept to rounding. With settings.stopping.converges() everything is in double precision, and sweeps
  /// are repeated as it says. Fills moved_m and turned_rad. The same bits on any number of threads and instruction set.
  Convergence solve(const ContactSystem& system, const SolveSettings& settings, parallel::Executor& executor);

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace poise::solver
