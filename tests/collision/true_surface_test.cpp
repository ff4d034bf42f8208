// SPDX-License-Identifier: MIT
#include "collision/triangles/true_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "geometry/meshes.h"
#include "geometry/primitives/triangle_distance.h"

namespace poise::collision {
namespace {

Pose at(const Vec3& position, const Mat3& rotation = Mat3::Identity()) { return {position, rotation}; }
TrueSurface box(const Vec3& size, Solidity solidity = Solidity::Solid) { return {test::box_mesh(size), solidity}; }
TrueSurface ball(double radius) {
  const Sphere one{Vec3::Zero(), radius};
  return TrueSurface(std::span(&one, 1));
}
Mat3 turn(double angle, const Vec3& axis) { return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(); }

TEST(SurfaceDistance, OfTwoBallsIsTheGapAndZeroInOverlap) {
  EXPECT_NEAR(surface_distance_m(ball(1), at({0, 0, 0}), ball(0.5), at({0, 3, 0})), 1.5, 1e-15);
  EXPECT_EQ(surface_distance_m(ball(1), at({0, 0, 0}), ball(0.5), at({0, 1.4, 0})), 0);
  EXPECT_EQ(surface_distance_m(ball(1), at({0, 0, 0}), ball(0.5), at({0, 0, 0})), 0);
}

TEST(SurfaceDistance, OfBoxesIsThatOfTheirFacesEdgesAndCorners) {
  const TrueSurface cube = box(Vec3::Constant(2));
  EXPECT_NEAR(surface_distance_m(cube, at({0, 0, 0}), cube, at({2.25, 0.3, 0.1})), 0.25, 1e-14);
  // Edge against edge, crossed, and a corner against a face.
  const Mat3 on_edge = turn(std::numbers::pi / 4, Vec3::UnitY());
  const Mat3 across = turn(std::numbers::pi / 4, Vec3::UnitX());
  const double far = 2 * std::numbers::sqrt2;
  EXPECT_NEAR(surface_distance_m(cube, at({0, 0, 0}, on_edge), cube, at({0, 0, far + 0.125}, across)), 0.125, 1e-14);
  const Mat3 on_corner = Quat::FromTwoVectors(Vec3(1, 1, 1), Vec3::UnitZ()).toRotationMatrix();
  EXPECT_NEAR(surface_distance_m(cube, at({0, 0, 0}), cube, at({0, 0, 1 + std::sqrt(3.0) + 0.5}, on_corner)), 0.5,
              1e-14);
  EXPECT_EQ(surface_distance_m(cube, at({0, 0, 0}), cube, at({1.9, 0.3, 0.1})), 0);
}

TEST(SurfaceDistance, KnowsBallsAndPlanesBesideMeshes) {
  const TrueSurface cube = box(Vec3(2, 4, 6));
  EXPECT_NEAR(surface_distance_m(cube, at({5, 5, 5}), ball(0.5), at({5, 5, 9})), 0.5, 1e-14);
  EXPECT_NEAR(surface_distance_m(ball(0.5), at({5, 5, 9}), cube, at({5, 5, 5})), 0.5, 1e-14);
  const TrueSurface floor(Vec3::UnitZ(), 1.0);
  EXPECT_NEAR(surface_distance_m(cube, at({0, 0, 4.75}), floor, at({0, 0, 0})), 0.75, 1e-14);
  EXPECT_NEAR(surface_distance_m(floor, at({0, 0, 0.25}), ball(0.5), at({0, 0, 2})), 0.25, 1e-14);
  EXPECT_EQ(surface_distance_m(cube, at({0, 0, 3.9}), floor, at({0, 0, 0})), 0);
}

TEST(SurfaceDistance, IsZeroInsideASolidAndNotInsideAShell) {
  const TrueSurface room = box(Vec3::Constant(10));
  const TrueSurface hull = box(Vec3::Constant(10), Solidity::Shell);
  const TrueSurface small = box(Vec3::Constant(1));
  EXPECT_EQ(surface_distance_m(room, at({0, 0, 0}), small, at({1, 0, 0})), 0);
  EXPECT_EQ(surface_distance_m(small, at({1, 0, 0}), room, at({0, 0, 0})), 0);
  EXPECT_EQ(surface_distance_m(room, at({0, 0, 0}), ball(0.5), at({1, 0, 0})), 0);
  EXPECT_NEAR(surface_distance_m(hull, at({0, 0, 0}), small, at({1, 0, 0})), 3.5, 1e-14);
}

TEST(SurfaceDistance, StopsAtItsLimit) {
  const TrueSurface cube = box(Vec3::Constant(2));
  EXPECT_EQ(surface_distance_m(cube, at({0, 0, 0}), cube, at({9, 0, 0}), 0.5), 0.5);
  EXPECT_EQ(surface_distance_m(cube, at({0, 0, 0}), TrueSurface(Vec3::UnitZ(), -9), at({0, 0, 0}), 0.5), 0.5);
  EXPECT_NEAR(surface_distance_m(cube, at({0, 0, 0}), cube, at({2.25, 0, 0}), 0.5), 0.25, 1e-14);
}

TEST(SurfaceDistance, AgreesWithAllPairsOfTriangles) {
  const TriangleMesh mesh_a = test::torus_mesh(1.0, 0.3, 14, 8);
  const TriangleMesh mesh_b = test::ball_mesh(0.6, 2);
  const TrueSurface a(mesh_a, Solidity::Solid);
  const TrueSurface b(mesh_b, Solidity::Solid);
  std::mt19937_64 bits(5);
  const auto unit = [&] { return static_cast<double>(bits() >> 11U) * 0x1.0p-53 - 0.5; };
  const auto corners = [](const TriangleMesh& mesh, const Pose& pose, std::size_t i) {
    geometry::TriangleCorners t;
    for (std::size_t k = 0; k < 3; ++k) t[k] = pose.rotation * mesh.vertices_m[mesh.triangles[i][k]] + pose.position_m;
    return t;
  };
  for (int round = 0; round < 12; ++round) {
    const Pose pose_a =
        at(2 * Vec3(unit(), unit(), unit()), Quat(unit(), unit(), unit(), unit()).normalized().toRotationMatrix());
    const Vec3 away = Vec3(unit(), unit(), unit()).normalized();
    const Pose pose_b = at(pose_a.position_m + (2.2 + unit()) * away,
                           Quat(unit(), unit(), unit(), unit()).normalized().toRotationMatrix());
    double expected = 1e300;
    for (std::size_t i = 0; i < mesh_a.triangles.size(); ++i) {
      const geometry::TriangleCorners s = corners(mesh_a, pose_a, i);
      for (std::size_t j = 0; j < mesh_b.triangles.size(); ++j) {
        expected = std::min(expected, geometry::distance_of_triangles_m(s, corners(mesh_b, pose_b, j)));
      }
    }
    EXPECT_NEAR(surface_distance_m(a, pose_a, b, pose_b), expected, 1e-12) << round;
    EXPECT_NEAR(surface_distance_m(b, pose_b, a, pose_a), expected, 1e-12) << round;
  }
}

TEST(TrueSurface, BlocksTheWayThroughItAndNoOther) {
  const TrueSurface plate = box(Vec3(2, 2, 0.01));
  EXPECT_TRUE(plate.blocks(Vec3(0.2, 0.3, 5), Vec3(0.2, 0.3, -5)));
  EXPECT_FALSE(plate.blocks(Vec3(1.2, 0.3, 5), Vec3(1.2, 0.3, -5)));
  EXPECT_FALSE(plate.blocks(Vec3(0.2, 0.3, 5), Vec3(0.2, 0.3, 1)));
  EXPECT_TRUE(ball(1).blocks(Vec3(-3, 0.9, 0), Vec3(3, 0.9, 0)));
  EXPECT_FALSE(ball(1).blocks(Vec3(-3, 1.1, 0), Vec3(3, 1.1, 0)));
  const TrueSurface floor(Vec3::UnitZ(), 1.0);
  EXPECT_TRUE(floor.blocks(Vec3(0, 0, 2), Vec3(9, 9, 0.5)));
  EXPECT_FALSE(floor.blocks(Vec3(0, 0, 2), Vec3(9, 9, 1.5)));
}

TEST(TrueSurface, OfAUnionOfSpheresIsItsSpheres) {
  const Sphere two[2] = {{Vec3(-1, 0, 0), 0.5}, {Vec3(1, 0, 0), 0.5}};
  const ShapePtr shape = make_spheres_shape(two).value();
  const TrueSurface surface = true_surface_of(*shape);
  // There is no surface between the two, although the root sphere of the tree is there.
  EXPECT_NEAR(surface_distance_m(surface, at({0, 0, 0}), ball(0.25), at({0, 0, 0})), 0.25, 1e-6);
  EXPECT_FALSE(surface.blocks(Vec3(0, -3, 0), Vec3(0, 3, 0)));
  EXPECT_TRUE(surface.blocks(Vec3(1, -3, 0), Vec3(1, 3, 0)));
}

}  // namespace
}  // namespace poise::collision
