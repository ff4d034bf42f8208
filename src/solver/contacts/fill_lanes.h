// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "solver/contacts/contact_blocks.h"

/// The ways between the records of pairs, in double precision and one after another, and the lanes of the solver.
namespace poise::solver {

/// What the lanes of a block are filled from. Lanes that are not in use name what is at rest, and have no points.
struct LaneSources {
  const Manifold* pairs[kLanes];
  const SolverBody* a[kLanes];
  const SolverBody* b[kLanes];
  const collision::Pose* pose_a[kLanes];
  const collision::Pose* pose_b[kLanes];
  const ContactPoint* points[kLanes];  ///< of each pair the first, and its force
  const ContactForce* forces[kLanes];
  std::uint8_t point_count[kLanes];
  std::uint8_t least_points;  ///< of these
  std::uint8_t warm;          ///< bit by lane: its contact points start from their forces
  double substep_s = 0;       ///< for so long
};

/// Fills the lanes of a block but for what prepare_block() completes: contact points placed at the poses of their
/// bodies (placed_point in contact_point.h, with the same bits, but their arms by share_of_gap), forces as impulses.
void fill_lanes(const LaneSources& sources, PairLanes<float>& shared, StartLanes<float>& start,
                std::span<PointLanes<float>> manifold_points);
void fill_lanes(const LaneSources& sources, PairLanes<double>& shared, StartLanes<double>& start,
                std::span<PointLanes<double>> manifold_points);

/// The total impulse that the b of each pair received in the step, and its moment about the centre of mass of a: a row
/// of three numbers and a zero for each pair.
struct LaneImpulses {
  alignas(64) double impulse_ns[kLanes][4];
  alignas(64) double moment_a_nms[kLanes][4];
};

/// Where the forces of the last substep go: of each lane in use so many, one after another.
struct LaneForces {
  ContactForce* first[kLanes];
  std::uint8_t point_count[kLanes] = {};
  std::size_t lanes = 0;  ///< in use
  double substep_s = 0;
};

/// Adds up the totals of the points of a block, and stores the forces of the last substep. Only for the lanes in use.
void collect_lanes(const PairLanes<float>& shared, std::span<const PointLanes<float>> manifold_points,
                   std::span<const TotalLanes<float>> totals, const LaneForces& forces, LaneImpulses& impulses);
void collect_lanes(const PairLanes<double>& shared, std::span<const PointLanes<double>> manifold_points,
                   std::span<const TotalLanes<double>> totals, const LaneForces& forces, LaneImpulses& impulses);

}  // namespace poise::solver
