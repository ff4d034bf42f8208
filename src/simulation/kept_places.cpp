// SPDX-License-Identifier: MIT
#include "simulation/kept_places.h"

namespace poise::simulation {

response::RestPlace keep(const PlacedPair& pair, const collision::Patch& patch) {
  response::RestPlace kept;
  const Mat3 to_b = pair.b.rotation.transpose();
  const Vec3 normal = pair.a.rotation * patch.normal;
  const Vec3 on_a = pair.a.position_m + pair.a.rotation * (patch.point_m - (0.5 * patch.gap_m) * patch.normal);
  // The normal of the pair points into the plane.
  const double gap_m = pair.plane ? -normal.dot(on_a) - pair.height_m : patch.gap_m;
  kept.normal = to_b * normal;
  kept.on_a_m = patch.point_m - (0.5 * patch.gap_m) * patch.normal;
  kept.on_b_m = to_b * (on_a + gap_m * normal - pair.b.position_m);
  kept.sureness_m = patch.surely_m - patch.gap_m;
  return kept;
}

void PlaceStore::reserve(std::size_t rooms) {
  places.reserve(rooms * kPlacesOfPair);
  loads.reserve(rooms * kPlacesOfPair);
  free.reserve(rooms);
}

void PlaceStore::make_room(std::size_t rooms) {
  if (rooms <= free.size()) return;
  const std::size_t first = places.size() / kPlacesOfPair;
  const std::size_t more = rooms - free.size();
  places.resize((first + more) * kPlacesOfPair);
  loads.resize(places.size());
  free.reserve(first + more);
  // The lowest of the new ones is taken first, after those that were given back.
  free.insert(free.begin(), more, 0);
  for (std::size_t k = 0; k < more; ++k) free[k] = static_cast<std::uint32_t>(first + more - 1 - k);
}

}  // namespace poise::simulation
