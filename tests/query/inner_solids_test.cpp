// SPDX-License-Identifier: MIT
#include "query/inner_solids.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "geometry/meshes.h"
#include "query/body_surface.h"
#include "query/brute_force.h"

namespace poise::query {
namespace {

const std::filesystem::path kSolidMeshes = std::filesystem::path(POISE_SOURCE_DIR) / "scenes/meshes";

Vec3 point_in(const InnerSolid& solid, std::mt19937_64& random) {
  const auto unit = [&] { return static_cast<double>(random() >> 11U) * 0x1.0p-52 - 1.0; };
  const double x = unit(), y = unit(), z = unit();
  const Vec3 cube(x, y, z);
  if (solid.radius_m > 0) return solid.center_m + solid.radius_m * cube / std::max(1.0, cube.norm());
  return solid.center_m + cube.cwiseProduct(solid.half_extents_m);
}

TEST(InnerSolids, AreInsideTheirMeshes) {
  std::mt19937_64 random(5);
  for (const char* name : {"jack.obj", "torus.obj", "bowl.obj", "l.obj", "slab.obj"}) {
    const ShapePtr shape = test::mesh_file(kSolidMeshes / name);
    const BodySurface surface(shape);
    const std::vector<InnerSolid> solids = inner_solids(shape);
    EXPECT_LE(solids.size(), kMostInnerSolids);
    for (const InnerSolid& solid : solids) {
      for (int i = 0; i < 300; ++i) EXPECT_TRUE(surface.contains(point_in(solid, random))) << name;
    }
  }
}

TEST(InnerSolids, FillABoxButForAFew) {
  const std::vector<InnerSolid> solids = inner_solids(test::mesh_shape(test::box_mesh(Vec3(4, 2, 0.2))));
  ASSERT_FALSE(solids.empty());
  EXPECT_GT(8 * solids.front().half_extents_m.prod(), 0.9 * 4 * 2 * 0.2);
}

TEST(InnerSolids, OfBallsAreTheLargestLeaves) {
  const std::vector<InnerSolid> one = inner_solids(make_sphere_shape(0.5).value());
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one.front().radius_m, 0.5);
  std::vector<Sphere> spheres;
  for (int i = 0; i < 12; ++i) spheres.push_back({Vec3(i, 0, 0), 0.1 + 0.01 * i});
  const std::vector<InnerSolid> several = inner_solids(make_spheres_shape(spheres).value());
  ASSERT_EQ(several.size(), kMostInnerSolids);
  EXPECT_NEAR(several.front().radius_m, 0.21, 1e-6);
  EXPECT_NEAR(several.back().radius_m, 0.14, 1e-6);
}

TEST(InnerSolids, OfAPlaneOrAShellAreNone) {
  EXPECT_TRUE(inner_solids(make_plane_shape(Vec3::UnitZ(), 0).value()).empty());
  const Result<ShapePtr> shell =
      make_mesh_shape(test::box_mesh(Vec3(1, 1, 1)), {.depth = 1, .preset = TreePreset::Fast}, 0.01);
  EXPECT_TRUE(inner_solids(shell.value()).empty());
}

}  // namespace
}  // namespace poise::query
