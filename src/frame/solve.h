// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "frame/manifolds.h"
#include "solver/contact_solver.h"
#include "solver/impacts/impact_row.h"
#include "solver/solver.h"

/// Stage *solve*: impulses of impacts, then forces and contacts, then (with backtracking) what meets within the step.
namespace poise::simulation {

struct SolveInput {
  SceneView scene;
  StepTerms terms;
  const PredictedMotion& motion;
  const PairTable& table;
  const CompletedLevels& levels;
  const Manifolds& manifolds;
  std::span<const collision::FrontPool> pools;  ///< of *refine*: the paper's model reads its fronts
  int substeps = 2;
  solver::Stopping stopping;
  solver::LaneMemory* memory = nullptr;  ///< to use instead of Velocities::lane_memory

  [[nodiscard]] solver::SolveSettings settings() const { return {terms.dt_s, terms.gravity_mps2, substeps, stopping}; }
};

/// Places for overlapping points that have been taken and are not used yet.
struct alignas(64) OverlapRoom {
  std::uint32_t next = 0, past = 0;
  std::uint32_t at_once = 0;  ///< so many are taken next, or as many as a row has points
};

/// Output of *solve*: velocities after the step, and the impulses that made them. Invariant: buffers only grow.
struct Velocities {
  bool everything = true;                                     ///< nothing is known of bodies at rest
  parallel::UnsetVector<solver::SolverBody> bodies;           ///< one a slot
  parallel::UnsetVector<solver::Acceleration> accelerations;  ///< SolverBody::acceleration: none, gravity, others
  std::vector<Vec3> applied_impulse_ns;      ///< one a manifold: what b received from the contact solver
  parallel::UnsetVector<Vec3> impact_ns;     ///< one a manifold where there were impacts: what b received from them
  solver::LaneMemory lane_memory;            ///< of rows while impacts are solved, then of contact points in lanes
  std::span<solver::ContactRow> rows;        ///< in the order of the colouring; filled where there was an impact
  std::span<solver::OverlapPoint> overlaps;  ///< of the rows
  std::uint64_t point_count = 0;  ///< of the manifolds that the contact solver takes: all but those that bounce
  SweptContacts swept;            ///< with backtracking

  solver::SolveScratch scratch;
  std::vector<OverlapRoom> overlap_rooms;        // scratch: one a worker
  std::vector<solver::PointContact> points;      // scratch: sphere contacts of the paper's model
  std::vector<std::uint32_t> points_begin;       // scratch, per manifold: likewise
  bool bounced = false;                          ///< some manifolds rebound: impacts answer them alone
  parallel::UnsetVector<std::uint8_t> left_out;  ///< if so, one a manifold: 1 of these

  [[nodiscard]] const solver::Acceleration& acceleration_of(std::size_t slot) const {
    return accelerations[bodies[slot].acceleration];
  }
  /// What b of a manifold received in the step, N s.
  [[nodiscard]] Vec3 impulse_ns(std::size_t manifold) const {
    const Vec3& applied_ns = applied_impulse_ns[manifold];
    return impact_ns.empty() ? applied_ns : Vec3(applied_ns + impact_ns[manifold]);
  }
};

/// First: velocities at the start of the step, and memory for the rest. Looks at the bodies that *predict* has visited,
/// or if velocities.everything, at all.
void begin_solve(const SolveInput& input, Velocities& velocities, parallel::Executor& executor);

/// Then the impacts, if there are any: a row is filled when it is first needed. Counts degenerate rows.
solver::Convergence solve_impacts(const SolveInput& input, const PointCache& points, Velocities& velocities,
                                  FrameReport& report, parallel::Executor& executor);

/// What resting contact is solved of, after begin_solve and solve_impacts.
solver::ContactSystem contact_system(const SolveInput& input, PointCache& points, Velocities& velocities);

/// How many iterations resting contact may make: fields of SolveSettings.
struct IterationsAllowed {
  std::uint32_t most = solver::kMaxPointIterations;  ///< point_iterations
  std::optional<SteadyClock::time_point> until;      ///< likewise
  std::span<const std::uint32_t> repeated;           ///< likewise
};
/// Then forces and the contacts. Warm started from the impulses in `points`, and leaves the new ones there.
solver::Convergence solve_contacts(const SolveInput& input, const IterationsAllowed& allowed, PointCache& points,
                                   solver::ContactSolver& contact_solver, Velocities& velocities,
                                   parallel::Executor& executor);

/// Fills all rows, after begin_solve; solve_impacts fills those that it needs. For the pair probe.
void fill_rows(const SolveInput& input, const PointCache& points, Velocities& velocities, parallel::Executor& executor);
/// What the solver of impacts works on, once there are rows.
solver::System impact_system(const SolveInput& input, Velocities& velocities);

/// The impact point of a pair, where it was at the start of the step.
solver::PlacedPoint impact_point_of(const PredictedMotion& motion, const PointCache& points, const ActivePair& pair,
                                    std::uint32_t slot);
/// What decides whether the surfaces of a pair touch.
struct SolvedPair {
  const SceneView& scene;
  const PredictedMotion& motion;
  const PairTable& table;
  const CompletedLevels& levels;
  const Manifolds& manifolds;
  const PointCache& points;
  ContactModel contact;
};
/// The estimated separation of the surfaces at the impact point; in the paper's model that of the spheres. `pair` is an
/// index into the pair table.
double solved_gap_m(const SolvedPair& solved, std::uint32_t pair);

}  // namespace poise::simulation
