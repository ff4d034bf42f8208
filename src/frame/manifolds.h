// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "frame/refine/refine.h"
#include "solver/contact_solver.h"
#include "solver/impacts/impact_row.h"

/// Stage *manifolds*: contact points of each pair from its deepest completed level or the contact cache, and the list
/// of those that the solver takes.
namespace poise::simulation {

struct ManifoldsInput {
  SceneView scene;
  StepTerms terms;
  const PredictedMotion& motion;
  const PairTable& table;
  const CompletedLevels& levels;
  double still_mps = 0;  ///< what closes more slowly is no impact
};

/// The contact points of a pair in this frame; they are in the point cache.
struct PairPoints {
  std::uint32_t slot = kNoSlot;
  std::uint8_t point_count = 0;
  bool solved = false;  ///< one of them is nearer than the margin: the solver takes the pair
  double nearest_m = 0, impact_gap_m = 0, looked_m = 0;  ///< likewise of CachedPair
};

/// What there is to solve among some pairs.
struct SolvedCount {
  std::uint32_t before = 0;  ///< solved pairs of all chunks before
  bool any_fast = false;     ///< one of them may have an impact
  std::uint32_t solved = 0, left = 0, cached_separations = 0, cached_contacts = 0;
  std::uint32_t manifold_points = 0;  ///< of the solved ones
  std::size_t held_found = 0;         ///< pairs that wait, with new points
  std::uint32_t unused_slots = 0;     ///< pairs that have a slot and no points any more
  std::uint32_t begin = 0;            ///< of the solved ones in Manifolds::of_chunk
  std::array<std::uint32_t, kPolygonBin + 1> levels{};
};

/// Output of *manifolds*. Invariant: buffers only grow.
struct Manifolds {
  parallel::UnsetVector<PairPoints> points;           ///< one a pair
  parallel::UnsetVector<solver::Manifold> manifolds;  ///< of the solved pairs, in canonical order
  parallel::UnsetVector<solver::Edge> edges;          ///< one a manifold
  solver::Coloring coloring;                          ///< of the edges
  std::uint64_t manifold_points = 0;                  ///< of all manifolds
  std::size_t held_found = 0;                         ///< pairs that wait, with new points
  bool impacts = false;                               ///< some pair may have an impact
  std::size_t unused_slots = 0;                       ///< of pairs without points: *publish* releases them
  std::vector<SolvedCount> solved_of_chunk;           ///< per chunk of pairs

  // Scratch: the manifolds of each chunk side by side, and slots for points.
  parallel::UnsetVector<solver::Manifold> of_chunk;
  SlotAllocator slots;
};

/// Writes the points of the pairs into `points`, and lists the manifolds.
void make_manifolds(const ManifoldsInput& input, PointCache& points, Manifolds& manifolds, FrameReport& report,
                    parallel::Executor& executor);

/// Where the contact of a pair whose points are not cached is: so much of the gap between the surfaces away from a.
/// Nothing is said of level 0 but between balls, or a ball and a plane: elsewhere root spheres are not the surfaces.
std::optional<double> share_of_contact(const PredictedMotion& motion, const ActivePair& pair,
                                       const PairProgress& progress);

/// The contact of a pair whose points are not cached: what its level found, or at level 0 that of its root spheres,
/// which is made in `coarsest`.
const collision::PairContact& contact_of(const SceneView& scene, const PredictedMotion& motion, const ActivePair& pair,
                                         const PairProgress& progress, const FoundContact& found,
                                         collision::PairContact& coarsest);

}  // namespace poise::simulation
