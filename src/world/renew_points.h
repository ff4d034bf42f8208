// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>

#include "collision/manifold/manifold_point.h"
#include "solver/contacts/contact_point.h"
#include "world/contact_cache.h"

/// What refinement finds of a pair takes the place of what is cached of it.
namespace poise::simulation {

/// Two bodies where they are now. Where b is a plane, `height_m` is that of its surface along its normal.
struct PlacedPair {
  const collision::Pose& a;
  const collision::Pose& b;
  bool plane = false;
  double height_m = 0;
};

/// The contact points of a pair that were found, in the frame of a, and the slot that they go to.
struct RenewedPoints {
  std::array<const collision::ManifoldPoint*, kPointsOfPair> found{};  ///< that of the impact, then the manifold
  std::size_t count = 0;                                               ///< 1 to kPointsOfPair
  solver::ContactPoint* points = nullptr;                              ///< of the slot, with room for them
  solver::ContactForce* forces = nullptr;                              ///< of the slot: that of a point has its index
  const solver::ContactPoint* old_points = nullptr;                    ///< those that they replace, there or elsewhere
  const solver::ContactForce* old_forces = nullptr;
  std::size_t old_count = 0;  ///< of the old points
  double alike_m = 0;         ///< a point within this of an old one, with nearly the same normal, is taken for it
};

/// Fixes the points to the two bodies; on a plane their separation becomes that of the plane itself. Points of the
/// manifold start from the forces of the old ones that they are taken for, others from none. Writes the separation of
/// each point at these poses. The same bits on any instruction set.
void renew_points(const PlacedPair& pair, const RenewedPoints& renewed, std::array<double, kPointsOfPair>& gaps_m);

}  // namespace poise::simulation
