// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "parallel/executor.h"
#include "poise/types.h"
#include "solver/contacts/contact_point.h"
#include "solver/lane_memory.h"
#include "solver/solver.h"

namespace poise::solver {

/// The contact points of one pair in resting contact; they are consecutive in ContactSystem::points, and so are their
/// forces, which have the same indices.
struct Manifold {
  std::uint32_t a = 0, b = 0;  ///< solver bodies
  std::uint32_t point_begin = 0;
  std::uint32_t pair = 0;        ///< the caller's index of the pair
  std::uint8_t point_count = 0;  ///< at most collision::kMaxManifoldPoints
  bool fast = false;             ///< set by the caller: the pair may have an impact
  double friction = 0;           ///< Coulomb's coefficient, >= 0
  double restitution =
      0;  ///< a contact point that closes fast enough to rebound is left to the impact phase of a later step
  double slop_m = 0;  ///< penetration that is not corrected
};

/// Bodies and pairs of one step. `coloring` is that of `pairs`, ranked by their numbers of contact points.
struct ContactSystem {
  std::span<SolverBody> bodies;
  std::span<const Acceleration> accelerations;  ///< those that SolverBody::acceleration means
  std::span<const Mat3> inverse_inertia;        ///< one a body, world frame
  std::span<const collision::Pose> poses;       ///< one a body
  std::span<const Manifold> pairs;
  std::span<const ContactPoint> points;
  std::span<ContactForce> forces;  ///< one a contact point: in, those of the last step (warm start); out, of this one
  std::span<Vec3> applied_impulse_ns;  ///< out, one a pair: the impulse that b received in the step
  const Coloring& coloring;
  std::uint64_t point_count = 0;  ///< of all pairs that are not left out
  /// With `only_active`, of all bodies those that may move, or are not what they were in the last step with the same
  /// solver; the others were at rest then and are.
  std::span<const std::uint32_t> active = {};
  bool only_active = false;
  std::span<const std::uint8_t> left_out = {};  ///< one a pair, or none: 1 of a pair that is not in resting contact
  LaneMemory* memory = nullptr;                 ///< for the lanes of contact points, if they are not to have their own

  [[nodiscard]] const Acceleration& acceleration_of(std::size_t body) const {
    return accelerations[bodies[body].acceleration];
  }
  /// Contact points of a pair that are solved.
  [[nodiscard]] std::uint8_t solved_points(std::uint32_t pair) const {
    return left_out.empty() || left_out[pair] == 0 ? pairs[pair].point_count : std::uint8_t{0};
  }
};

/// Lanes of the solver: eight pairs of a colour side by side. Invariant: buffers only grow.
class ContactSolver {
 public:
  ContactSolver();
  ~ContactSolver();
  ContactSolver(ContactSolver&&) noexcept;
  ContactSolver& operator=(ContactSolver&&) noexcept;

  /// Applies forces and solves resting contact (docs/response.md). In `substeps` substeps (Macklin et al. 2019) each
  /// contact point gets the normal impulse that prevents penetration at the end of the substep, warm started from the
  /// last step, and Coulomb friction within its cone. Certain penetration is corrected by positions alone. A substep
  /// iterates over its contact points until they converge, at most settings.point_iterations of them. Impulses are
  /// computed in single precision from changes within the step and applied in double precision at its end: linear and
  /// angular momentum are conserved to rounding. With settings.stopping.converges() all of it is in double precision,
  /// and iterations end as it says. Fills moved_m and turned_rad. The same bits on any number of threads and
  /// instruction set.
  Convergence solve(const ContactSystem& system, const SolveSettings& settings, parallel::Executor& executor);
  /// Of the last solve. Times only if it had to end in time.
  [[nodiscard]] const IterationsMade& made() const;

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace poise::solver
