// SPDX-License-Identifier: MIT
#include "geometry/mesh/bumpy_ball.h"

#include <gtest/gtest.h>

namespace poise::testing {
namespace {

TEST(BumpyBall, IsClosedAndOutwardWithTheTrianglesAskedForOrAFewMore) {
  for (const std::size_t asked : {1U, 21U, 1000U, 3162U, 10000U}) {
    const Result<TriangleMesh> mesh = geometry::bumpy_ball(asked);
    ASSERT_TRUE(mesh) << mesh.error().message;
    const std::size_t triangles = mesh.value().triangles.size();
    EXPECT_GE(triangles, asked);
    EXPECT_LE(static_cast<double>(triangles), 20.0 + 1.5 * static_cast<double>(asked) + 60);
    EXPECT_TRUE(check_closed(mesh.value()).closed()) << asked;
    EXPECT_EQ(mesh.value().vertices_m.size(), triangles / 2 + 2) << "every vertex is made once (Euler)";
    EXPECT_GT(mesh_mass_properties(mesh.value()).value().volume_m3, 0) << asked;
  }
}

TEST(BumpyBall, IsTheSameSurfaceHoweverFinelyItIsCut) {
  const TriangleMesh mesh = geometry::bumpy_ball(5000).value();
  const double coarse = mesh_mass_properties(mesh).value().volume_m3;
  const double fine = mesh_mass_properties(geometry::bumpy_ball(20000).value()).value().volume_m3;
  EXPECT_NEAR(coarse, fine, 0.005 * fine);
  for (const Vec3& vertex_m : mesh.vertices_m) {
    EXPECT_GE(vertex_m.norm(), 0.25 - 1e-12);
    EXPECT_LE(vertex_m.norm(), 0.5 + 1e-12);
  }
}

TEST(BumpyBall, RefusesCountsOutOfRange) {
  EXPECT_FALSE(geometry::bumpy_ball(0));
  EXPECT_FALSE(geometry::bumpy_ball(20000001));
}

}  // namespace
}  // namespace poise::testing
