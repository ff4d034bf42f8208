// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/mesh/procedural.h"

namespace poise::geometry {
namespace {

TEST(ProceduralBlock, ABoxIsClosedAndHasTheMassOfItsSize) {
  const TriangleMesh mesh = make_box({0.4, 0.2, 0.1}).value();
  EXPECT_EQ(mesh.triangles.size(), 12U);
  ASSERT_TRUE(check_closed(mesh).closed());
  const MassProperties mass = mesh_mass_properties(mesh).value();
  EXPECT_NEAR(mass.volume_m3, 0.008, 1e-15);
  EXPECT_LT(mass.center_of_mass_m.norm(), 1e-15);
  EXPECT_NEAR(mass.inertia_m5(0, 0), 0.008 * (0.2 * 0.2 + 0.1 * 0.1) / 12, 1e-15);
}

TEST(ProceduralBlock, StonesOfAnArchFillItAndShareTheirFaces) {
  constexpr int kStones = 11;
  const WedgeSize size{0.875, 1.125, 180.0 / kStones, 0.4};
  const TriangleMesh mesh = make_wedge(size).value();
  ASSERT_TRUE(check_closed(mesh).closed());
  // Two triangles between chords of half an angle a: (R^2 - r^2) sin a cos a.
  const double half = 0.5 * std::numbers::pi / kStones;
  const double expected = (1.125 * 1.125 - 0.875 * 0.875) * std::sin(half) * std::cos(half) * 0.4;
  EXPECT_NEAR(mesh_mass_properties(mesh).value().volume_m3, expected, 1e-8);
  const Eigen::AngleAxisd next(2 * half, Vec3::UnitY());
  std::size_t shared = 0;
  for (const Vec3& mine : mesh.vertices_m) {
    for (const Vec3& other : mesh.vertices_m) shared += (mine - next * other).norm() < 3e-9 ? 1U : 0U;
  }
  EXPECT_EQ(shared, 4U);
}

TEST(ProceduralBlock, RefusesSizesOutOfRange) {
  EXPECT_EQ(make_box({1, 0, 1}).error().message, "size = 0, must be from 1e-05 to 100000 m");
  EXPECT_FALSE(make_box({1, 1, std::nan("")}).ok());
  EXPECT_FALSE(make_box({1e6, 1, 1}).ok());
  EXPECT_EQ(make_wedge({2, 1, 20, 1}).error().message, "outer = 1, must be more than inner = 2");
  EXPECT_EQ(make_wedge({1, 2, 120, 1}).error().message, "angle = 120, must be from 0.1 to 90 degrees");
  EXPECT_FALSE(make_wedge({1, 2, 20, -1}).ok());
}

}  // namespace
}  // namespace poise::geometry
