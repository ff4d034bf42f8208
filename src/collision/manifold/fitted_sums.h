// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "collision/front/front.h"
#include "collision/front/pair_frame.h"
#include "collision/manifold/manifold_clusters.h"
#include "poise/types.h"

namespace poise::collision {

/// Sums over the entries of a front whose contacts come from the fitted spheres of the nodes (docs/method.md, "The
/// contact of a pair"); the frame of a. Entry k has the gap g of the two fitted spheres, the unit vector n from the
/// first centre to the second, the point p in the middle between the two surfaces, and the weight w = exp(-(g - g0) /
/// b), its exponent clamped to [-16, 6]; g0 is the expected gap and b the width (PairFrame). Directions use broad
/// weights, positions sharp ones. Sums of parts add up, so a front may be summed in pieces, in order.
struct FittedSums {
  Vec3 direction = Vec3::Zero();  ///< sum of w n
  Vec3 point_m = Vec3::Zero();    ///< sum of w^8 p
  double weight = 0;              ///< sum of w^8
  double fitted_m = 1e300;        ///< least gap of two fitted spheres
  double cores_m = 1e300;         ///< least gap of two cores: below zero the objects certainly penetrate
};

/// Single precision in blocks of eight, the same bits on any instruction set. For two trees or a tree and a plane.
void add_fitted(const PairFrame& frame, std::span<const FrontEntry> entries, FittedSums& sums);

/// The least gaps alone, which are all that the next level reads of one that it follows at once; `weight` counts
/// entries then.
void add_least_gaps(const PairFrame& frame, std::span<const FrontEntry> entries, FittedSums& sums);

/// The contacts of as many entries as there are lanes. The same bits likewise.
void fitted_contacts(const PairFrame& frame, std::span<const FrontEntry, NodeContacts::kLanes> entries,
                     NodeContacts& into);

}  // namespace poise::collision
