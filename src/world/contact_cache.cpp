// SPDX-License-Identifier: MIT
#include "world/contact_cache.h"

#include "parallel/ranges.h"

namespace poise::simulation {

solver::ContactPoint keep(const PlacedPair& pair, const collision::ManifoldPoint& manifold_point) {
  solver::ContactPoint cached;
  const Mat3 to_b = pair.b.rotation.transpose();
  const Vec3 normal = pair.a.rotation * manifold_point.normal;
  const Vec3 on_a = pair.a.position_m +
                    pair.a.rotation * (manifold_point.point_m - (0.5 * manifold_point.gap_m) * manifold_point.normal);
  // The normal of the pair points into the plane.
  const double gap_m = pair.plane ? -normal.dot(on_a) - pair.height_m : manifold_point.gap_m;
  cached.normal = to_b * normal;
  cached.on_a_m = manifold_point.point_m - (0.5 * manifold_point.gap_m) * manifold_point.normal;
  cached.plane_b_m = normal.dot(on_a - pair.b.position_m) + gap_m;
  cached.certainty_m = manifold_point.certain_separation_m - manifold_point.gap_m;
  return cached;
}

void PointCache::reserve(std::size_t slots) {
  points.reserve(slots * kPointsOfPair);
  forces.reserve(slots * kForcesOfPair);
  free.reserve(slots);
}

void PointCache::reserve_slots(std::size_t count, parallel::Executor& executor) {
  if (count <= free.size()) return;
  const std::size_t first = points.size() / kPointsOfPair;
  const std::size_t more = count - free.size();
  parallel::resize(executor, points, (first + more) * kPointsOfPair);
  parallel::resize(executor, forces, (first + more) * kForcesOfPair);
  free.reserve(first + more);
  // The lowest of the new ones is taken first, after those that were released.
  free.insert(free.begin(), more, 0);
  for (std::size_t k = 0; k < more; ++k) free[k] = static_cast<std::uint32_t>(first + more - 1 - k);
}

}  // namespace poise::simulation
