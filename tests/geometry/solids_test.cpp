// SPDX-License-Identifier: MIT
#include "geometry/mesh/solids.h"

#include <gtest/gtest.h>

#include <numbers>

namespace poise::geometry {
namespace {

/// Closed and outward, and its box and volume are those of the solid: `share` of the volume may be missing.
void expect_solid(const TriangleMesh& mesh, const Vec3& half_m, double volume_m3, double share) {
  TriangleMesh again = mesh;
  const MeshRepair repair = clean_mesh(again, 1e-6);
  EXPECT_EQ(repair.vertices_welded + repair.triangles_discarded + repair.triangles_turned, 0U);
  const Result<MassProperties> mass = mesh_mass_properties(mesh);
  ASSERT_TRUE(mass.ok()) << mass.error().message;
  EXPECT_LE(mass.value().volume_m3, volume_m3 * (1 + 1e-12));
  EXPECT_GE(mass.value().volume_m3, volume_m3 * (1 - share));
  EXPECT_LE(mass.value().center_of_mass_m.norm(), 1e-12);
  Vec3 most = Vec3::Zero();
  for (const Vec3& v : mesh.vertices_m) most = most.cwiseMax(v.cwiseAbs());
  EXPECT_LE((most - half_m).norm(), 1e-12);
}

TEST(Solids, HaveTheSizesAndVolumesOfTheirNames) {
  expect_solid(box_solid({1, 2, 3}), {1, 2, 3}, 48, 1e-12);
  expect_solid(ellipsoid_solid({1, 2, 3}), {1, 2, 3}, 8 * std::numbers::pi, 0.025);
  expect_solid(cylinder_solid(2, 5), {2, 2, 5}, 40 * std::numbers::pi, 0.0065);
  expect_solid(capsule_solid(2, 5), {2, 2, 7}, 40 * std::numbers::pi + 32 * std::numbers::pi / 3, 0.012);
}

}  // namespace
}  // namespace poise::geometry
