// SPDX-License-Identifier: MIT
#include "simulation/kept_places.h"

namespace poise::simulation {

KeptPlace keep(const PlacedPair& pair, const collision::Patch& patch) {
  KeptPlace kept;
  const Mat3 to_b = pair.b.rotation.transpose();
  kept.normal = to_b * (pair.a.rotation * patch.normal);
  kept.on_a_m = patch.point_m - (0.5 * patch.gap_m) * patch.normal;
  const Vec3 on_b = patch.point_m + (0.5 * patch.gap_m) * patch.normal;
  if (!pair.plane) kept.on_b_m = to_b * (pair.a.position_m + pair.a.rotation * on_b - pair.b.position_m);
  kept.sureness_m = patch.surely_m - patch.gap_m;
  return kept;
}

response::RestPatch placed(const PlacedPair& pair, const KeptPlace& kept) {
  response::RestPatch patch;
  patch.normal = pair.b.rotation * kept.normal;
  const Vec3 arm_a = pair.a.rotation * kept.on_a_m;
  if (pair.plane) {
    // The normal of the pair points into the plane.
    patch.gap_m = -patch.normal.dot(pair.a.position_m + arm_a) - pair.height_m;
  } else {
    patch.gap_m = patch.normal.dot(pair.b.position_m - pair.a.position_m + pair.b.rotation * kept.on_b_m - arm_a);
  }
  patch.arm_m = arm_a + (0.5 * patch.gap_m) * patch.normal;
  patch.surely_m = patch.gap_m + kept.sureness_m;
  patch.impulse_ns = kept.impulse_ns;
  patch.friction_ns = pair.b.rotation * kept.friction_ns;
  return patch;
}

void keep_impulse(const PlacedPair& pair, const response::RestPatch& solved, KeptPlace& kept) {
  kept.impulse_ns = solved.impulse_ns;
  kept.friction_ns = pair.b.rotation.transpose() * solved.friction_ns;
}

}  // namespace poise::simulation
