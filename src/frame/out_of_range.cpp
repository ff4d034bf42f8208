// SPDX-License-Identifier: MIT
#include "frame/out_of_range.h"

#include <algorithm>

namespace poise::simulation {

void forget_contacts_of(std::span<const std::uint32_t> slots, const PairTable& table, const Manifolds& manifolds,
                        PointCache& points, Velocities& velocities) {
  const auto one_of = [&](std::uint32_t slot) { return std::ranges::binary_search(slots, slot); };
  for (std::size_t m = 0; m < manifolds.manifolds.size(); ++m) {
    const solver::Manifold& manifold = manifolds.manifolds[m];
    if (!one_of(manifold.a) && !one_of(manifold.b)) continue;
    const PairPoints& made = manifolds.points[manifold.pair];
    for (solver::ContactForce& force : points.forces_of(made.slot, made.point_count)) force = {};
    velocities.applied_impulse_ns[m].setZero();
    if (!velocities.impact_ns.empty()) velocities.impact_ns[m].setZero();
  }
  for (SweptHit& hit : velocities.swept.hits) {
    const ActivePair& pair = table.pairs[hit.pair];
    if (one_of(pair.a) || one_of(pair.b)) hit.impulse_ns.setZero();
  }
}

}  // namespace poise::simulation
