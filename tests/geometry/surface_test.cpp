// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "geometry/tree_layout.h"
#include "geometry/tree_surface.h"
#include "meshes.h"

namespace poise::geometry {
namespace {

constexpr double kStep = 1.0 / 32767;

/// What the only node of a tree of one ball knows of a mesh.
NodeSurface surface_in(const TriangleMesh& mesh, const Vec3& center_m, double radius_m) {
  LooseNode node;
  node.center_m = center_m.cast<float>();
  node.radius_m = static_cast<float>(radius_m);
  SphereTree tree = lay_out_tree({node});
  const auto serial = parallel::make_executor(ExecutorKind::Serial, 1);
  measure_surfaces(tree, TriangleBvh(mesh), *serial);
  return tree.surface[0];
}

Vec3 mean_normal(const NodeSurface& s) { return kStep * Vec3(s.normal[0], s.normal[1], s.normal[2]); }

TEST(NodeSurface, OfABallOnTheMiddleOfAFaceIsADisc) {
  const NodeSurface s = surface_in(test::box_mesh({2, 2, 2}), {1, 0, 0}, 0.25);
  EXPECT_NEAR(s.area_m2, std::numbers::pi / 16, 1e-7);
  EXPECT_LT((mean_normal(s) - Vec3::UnitX()).norm(), 2 * kStep);
  EXPECT_EQ(s.offset, 0);
}

TEST(NodeSurface, OfABallOnAnEdgeIsTwoHalfDiscs) {
  const double r = 0.25;
  const NodeSurface s = surface_in(test::box_mesh({2, 2, 2}), {1, 1, 0.125}, r);
  EXPECT_NEAR(s.area_m2, std::numbers::pi * r * r, 1e-7);
  EXPECT_LT((mean_normal(s) - Vec3(0.5, 0.5, 0)).norm(), 2 * kStep);
  // The centroid of a half disc is 4 r / 3 pi from its straight side.
  EXPECT_NEAR(s.offset * kStep, -4 / (3 * std::numbers::pi) / std::sqrt(2.0), 2 * kStep);
}

TEST(NodeSurface, OffsetIsTheWayFromTheCentreToThePlane) {
  for (const double depth : {-0.2, -0.05, 0.1, 0.3}) {
    const NodeSurface s = surface_in(test::box_mesh({4, 4, 4}), {0.25, -0.5, 2 - depth}, 0.5);
    EXPECT_NEAR(s.area_m2, std::numbers::pi * (0.25 - depth * depth), 1e-5);
    EXPECT_NEAR(s.offset * kStep * 0.5, depth, 1e-4);
    EXPECT_NEAR(mean_normal(s).z(), 1, 2 * kStep);
  }
}

TEST(NodeSurface, OfAWholeClosedMeshIsItsAreaWithoutADirection) {
  const NodeSurface s = surface_in(test::box_mesh({1, 2, 3}), Vec3::Zero(), 5);
  EXPECT_NEAR(s.area_m2, 22, 1e-5);
  EXPECT_EQ(mean_normal(s), Vec3::Zero());
  EXPECT_EQ(s.offset, 0);
}

TEST(NodeSurface, OfABallThatTheSurfaceDoesNotEnterIsZero) {
  for (const Vec3& center : {Vec3(0, 0, 0), Vec3(3, 0, 0)}) {
    const NodeSurface s = surface_in(test::box_mesh({2, 2, 2}), center, 0.5);
    EXPECT_EQ(s.area_m2, 0);
    EXPECT_EQ(mean_normal(s), Vec3::Zero());
    EXPECT_EQ(s.offset, 0);
  }
}

TEST(NodeSurface, OnABallMeshPointsOutward) {
  const TriangleMesh mesh = test::ball_mesh(1, 4);
  std::mt19937_64 random(3);
  for (int i = 0; i < 50; ++i) {
    const Vec3 way = test::random_in_box(random, Vec3::Constant(-1), Vec3::Constant(1)).normalized();
    const double r = 0.2;
    const NodeSurface s = surface_in(mesh, way, r);
    // A cap of a sphere within r of a point of it has area pi r^2 exactly; the facets are 0.3 % smaller at most.
    EXPECT_NEAR(s.area_m2, std::numbers::pi * r * r, 0.005 * std::numbers::pi * r * r);
    EXPECT_GT(mean_normal(s).dot(way), 0.985);
    EXPECT_LT(mean_normal(s).norm(), 1);
  }
}

RC_GTEST_PROP(TriangleInBall, AreaAndCentroidAreThoseOfItsPointsInside, (std::uint32_t seed)) {
  std::mt19937_64 random(seed);
  const auto any = [&] { return test::random_in_box(random, Vec3::Constant(-1), Vec3::Constant(1)); };
  const TriangleCorners t{any(), any(), any()};
  const Sphere ball{any(), 0.2 + test::uniform(random)};
  const Vec3 across = (t[1] - t[0]).cross(t[2] - t[0]);
  RC_PRE(across.norm() > 0.05);
  const SurfacePiece piece = triangle_in_ball(t, across.normalized(), ball);
  // Middles of a fine cut into equal triangles.
  constexpr int kParts = 80;
  const double share = 0.5 * across.norm() / (kParts * kParts);
  double area = 0;
  Vec3 moment = Vec3::Zero();
  const auto count = [&](double u, double v) {
    const Vec3 from = t[0] + u / kParts * (t[1] - t[0]) + v / kParts * (t[2] - t[0]) - ball.center_m;
    if (from.norm() > ball.radius_m) return;
    area += share;
    moment += share * from;
  };
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; i + j < kParts; ++j) {
      count(i + 1.0 / 3, j + 1.0 / 3);
      if (i + j + 1 < kParts) count(i + 2.0 / 3, j + 2.0 / 3);
    }
  }
  const double error = 0.01 * across.norm();
  RC_ASSERT(std::abs(piece.area_m2 - area) <= error);
  RC_ASSERT((piece.moment_m3 - moment).norm() <= error);
}

TEST(NodeSurface, IsTheSameOnAnyNumberOfThreads) {
  const TriangleMesh mesh = make_procedural_shape("jack").value();
  SphereTree one = build_sphere_tree(mesh, {.depth = 1, .preset = TreePreset::Fast}).value();
  SphereTree two = one;
  const TriangleBvh bvh(mesh);
  measure_surfaces(one, bvh, *parallel::make_executor(ExecutorKind::Serial, 1));
  measure_surfaces(two, bvh, *parallel::make_executor(ExecutorKind::Threads, 3));
  for (NodeIndex node = 0; node < one.node_count(); ++node) {
    EXPECT_EQ(one.surface[node].normal, two.surface[node].normal);
    EXPECT_EQ(one.surface[node].offset, two.surface[node].offset);
    EXPECT_EQ(one.surface[node].area_m2, two.surface[node].area_m2);
  }
  EXPECT_GT(one.surface[one.node_count() - 1].area_m2, 0);
}

}  // namespace
}  // namespace poise::geometry
