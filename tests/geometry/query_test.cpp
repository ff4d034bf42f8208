// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/primitives/enclosing_ball.h"
#include "geometry/primitives/sampling.h"
#include "meshes.h"

namespace poise::geometry {
namespace {

using test::random_in_box;

TEST(TriangleBvh, ClosestDistanceIsThatOfASearchOverAllTriangles) {
  const TriangleMesh mesh = make_procedural_shape("l").value();
  const TriangleBvh bvh(mesh);
  std::mt19937_64 random(5);
  for (int i = 0; i < 300; ++i) {
    const Vec3 point = random_in_box(random, Vec3::Constant(-1), Vec3::Constant(1));
    EXPECT_NEAR(std::sqrt(bvh.closest(point).squared_distance_m2), test::slow_distance(mesh, point), 1e-6);
  }
}

TEST(TriangleBvh, TheClosestPointLiesAtTheClosestDistance) {
  const TriangleMesh mesh = make_procedural_shape("torus").value();
  const TriangleBvh bvh(mesh);
  std::mt19937_64 random(6);
  for (int i = 0; i < 60; ++i) {
    const Vec3 point = random_in_box(random, Vec3::Constant(-1), Vec3::Constant(1));
    const auto closest = bvh.closest(point);
    EXPECT_NEAR((closest.point_m - point).squaredNorm(), closest.squared_distance_m2, 1e-12);
    EXPECT_LT(test::slow_distance(mesh, closest.point_m), 1e-6);
  }
}

TEST(TriangleBvh, WindingNumberIsThatOfTheSumOverAllTriangles) {
  for (const char* kind : {"jack", "bowl", "torus"}) {
    const TriangleMesh mesh = make_procedural_shape(kind).value();
    const TriangleBvh bvh(mesh);
    std::mt19937_64 random(7);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 point = random_in_box(random, Vec3::Constant(-0.7), Vec3::Constant(0.7));
      const double winding = test::slow_winding(mesh, point);
      EXPECT_NEAR(bvh.winding_number(point), winding, 0.3) << kind;
      EXPECT_EQ(bvh.inside(point), winding > 0.5) << kind;
    }
  }
}

TEST(TriangleBvh, TheHollowOfABallInABallIsOutside) {
  TriangleMesh mesh = test::ball_mesh(1, 3);
  TriangleMesh hollow = test::ball_mesh(0.5, 3);
  const auto base = static_cast<std::uint32_t>(mesh.vertices_m.size());
  mesh.vertices_m.insert(mesh.vertices_m.end(), hollow.vertices_m.begin(), hollow.vertices_m.end());
  for (const auto& t : hollow.triangles) mesh.triangles.push_back({t[0] + base, t[2] + base, t[1] + base});
  const TriangleBvh bvh(mesh);
  EXPECT_FALSE(bvh.inside({0.1, 0.2, 0}));
  EXPECT_TRUE(bvh.inside({0.7, 0.1, 0}));
  EXPECT_FALSE(bvh.inside({1.1, 0, 0}));
  EXPECT_NEAR(bvh.signed_distance_m({0.75, 0, 0}), -0.25, 0.01);
  EXPECT_NEAR(bvh.signed_distance_m(Vec3::Zero()), 0.5, 0.02);
  EXPECT_EQ(bvh.outside_distance_m({0.75, 0, 0}), 0);
}

TEST(TriangleBvh, ATriangleWithoutAreaIsItsLongestEdge) {
  TriangleMesh mesh;
  mesh.vertices_m = {Vec3::Zero(), Vec3::UnitX(), 0.5 * Vec3::UnitX()};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_DOUBLE_EQ(TriangleBvh(mesh).closest({0.3, 2, 0}).squared_distance_m2, 4);
  EXPECT_DOUBLE_EQ(TriangleBvh(mesh).closest({3, 0, 0}).squared_distance_m2, 4);
}

TEST(TriangleBvh, NamesTheTriangleOfTheClosestPoint) {
  const TriangleMesh mesh = make_procedural_shape("jack").value();
  const TriangleBvh bvh(mesh);
  std::mt19937_64 random(9);
  for (int i = 0; i < 500; ++i) {
    const Vec3 point = random_in_box(random, Vec3::Constant(-0.7), Vec3::Constant(0.7));
    const auto closest = bvh.closest(point);
    ASSERT_LT(closest.triangle, mesh.triangles.size());
    const auto& t = mesh.triangles[closest.triangle];
    const TriangleCorners corners{mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]};
    EXPECT_EQ(bvh.corners(closest.triangle), corners);
    EXPECT_NEAR(std::sqrt(closest.squared_distance_m2), test::slow_distance(corners, point), 1e-6);
    EXPECT_LT(
        (bvh.triangle_normal(closest.triangle) - (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized())
            .norm(),
        1e-12);
    // Any guess gives the same distance.
    const auto guessed = bvh.closest_from(point, static_cast<std::uint32_t>(random() % mesh.triangles.size()));
    EXPECT_EQ(guessed.squared_distance_m2, closest.squared_distance_m2);
    EXPECT_EQ(bvh.closest_from(point, TriangleBvh::kNoTriangle).squared_distance_m2, closest.squared_distance_m2);
  }
}

TEST(TriangleBvh, FindsNothingBeyondTheBound) {
  const TriangleBvh bvh(test::box_mesh({2, 2, 2}));
  EXPECT_EQ(bvh.closest({3, 0, 0}, 3.99).triangle, TriangleBvh::kNoTriangle);
  EXPECT_EQ(bvh.closest({3, 0, 0}, 3.99).squared_distance_m2, 3.99);
  EXPECT_DOUBLE_EQ(bvh.closest({3, 0, 0}, 4.01).squared_distance_m2, 4);
  const TriangleBvh none{TriangleMesh{}};
  EXPECT_EQ(none.closest({0, 0, 0}).triangle, TriangleBvh::kNoTriangle);
  EXPECT_FALSE(none.inside({0, 0, 0}));
}

TEST(TriangleBvh, AnswersFarFromTheOriginAsNearIt) {
  const TriangleMesh mesh = make_procedural_shape("l").value();
  const Vec3 shift(9e5, -3e5, 7e5);
  const TriangleMesh far = test::moved(mesh, 1, Mat3::Identity(), shift);
  const TriangleBvh bvh(mesh);
  const TriangleBvh far_bvh(far);
  std::mt19937_64 random(10);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 point = random_in_box(random, Vec3::Constant(-2), Vec3::Constant(2));
    EXPECT_NEAR(far_bvh.signed_distance_m(point + shift), bvh.signed_distance_m(point), 1e-8);
  }
}

TEST(TriangleBvh, PointsInLineWithVerticesAndEdgesHaveAWholeWindingNumber) {
  // All coordinates are round, so rays along the axes pass through vertices, along edges and within faces.
  TriangleMesh mesh = test::box_mesh({2, 2, 2});
  const TriangleMesh other = test::moved(mesh, 0.5, Mat3::Identity(), {1, 0.5, 0.5});
  for (const auto& t : other.triangles) mesh.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  mesh.vertices_m.insert(mesh.vertices_m.end(), other.vertices_m.begin(), other.vertices_m.end());
  const TriangleBvh bvh(mesh);
  int both = 0;
  for (int x = -9; x <= 9; ++x) {
    for (int y = -9; y <= 9; ++y) {
      for (int z = -9; z <= 9; ++z) {
        const Vec3 p = Vec3(x, y, z) / 4;
        if (bvh.closest(p).squared_distance_m2 == 0) continue;
        const int expected =
            ((p.array().abs() < 1).all() ? 1 : 0) + (((p - Vec3(1, 0.5, 0.5)).array().abs() < 0.5).all() ? 1 : 0);
        EXPECT_EQ(bvh.winding_number(p), expected) << p.transpose();
        EXPECT_EQ(bvh.inside(p), expected > 0);
        both += expected == 2 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(both, 0);
}

TEST(TriangleBvh, AnOpenMeshWindsAsTheSumOverItsTriangles) {
  TriangleMesh mesh = make_procedural_shape("bowl").value();
  mesh.triangles.resize(mesh.triangles.size() * 3 / 4);
  const TriangleBvh bvh(mesh);
  EXPECT_FALSE(bvh.closed());
  std::mt19937_64 random(11);
  int near_half = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 point = random_in_box(random, Vec3::Constant(-0.7), Vec3::Constant(0.7));
    const double winding = test::slow_winding(mesh, point);
    const bool unsure = std::abs(std::abs(winding) - 0.5) < 0.2;
    EXPECT_NEAR(bvh.winding_number(point), winding, unsure ? 0.05 : 0.3);
    if (std::abs(std::abs(winding) - 0.5) > 0.05) {
      EXPECT_EQ(bvh.inside(point), std::abs(winding) > 0.5);
    }
    near_half += unsure ? 1 : 0;
  }
  EXPECT_GT(near_half, 20);
}

TEST(TriangleBvh, NothingIsInsideAShell) {
  const TriangleBvh bvh(test::box_mesh({2, 2, 2}), Solidity::Shell);
  EXPECT_FALSE(bvh.inside(Vec3::Zero()));
  EXPECT_DOUBLE_EQ(bvh.outside_distance_m({0.25, 0, 0}), 0.75);
  EXPECT_DOUBLE_EQ(bvh.signed_distance_m({0.25, 0, 0}), 0.75);
}

TEST(TriangleBvh, TrianglesNearAreAtLeastThoseWithinTheRadius) {
  const TriangleMesh mesh = make_procedural_shape("torus").value();
  const TriangleBvh bvh(mesh);
  std::mt19937_64 random(12);
  std::vector<std::uint32_t> near;
  for (int i = 0; i < 100; ++i) {
    const Vec3 point = random_in_box(random, Vec3::Constant(-0.6), Vec3::Constant(0.6));
    near.clear();
    bvh.triangles_near(point, 0.2, near);
    std::ranges::sort(near);
    EXPECT_TRUE(std::ranges::adjacent_find(near) == near.end());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      if ((closest_on_triangle(point, bvh.corners(t)) - point).norm() > 0.2) continue;
      EXPECT_TRUE(std::ranges::binary_search(near, t));
    }
  }
}

TEST(TriangleBvh, AWayEntersWhereItPassesATriangleFromItsFront) {
  const TriangleBvh box(test::box_mesh({2, 2, 0.02}));
  EXPECT_FALSE(box.enters_between({0.3, 0.2, 0.005}, {0.3, 0.2, 0.01})) << "from inside to the surface";
  EXPECT_FALSE(box.enters_between({0.3, 0.2, 0.005}, {0.3, 0.2, 0.03})) << "out of it";
  EXPECT_TRUE(box.enters_between({0.3, 0.2, -0.03}, {0.3, 0.2, 0.01})) << "through all of it";
  EXPECT_TRUE(box.enters_between({0.3, 0.2, 0.03}, {0.3, 0.2, 0.005})) << "into it";
  EXPECT_TRUE(box.enters_between({1, 1, -0.03}, {1, 1, 0.01})) << "at its corner, along two sides";
  EXPECT_FALSE(box.enters_between({1, 0.2, -0.005}, {1, 0.2, 0.01})) << "along a side";
  EXPECT_FALSE(box.enters_between({0.3, 0.2, 0.03}, {0.4, 0.2, 0.005})) << "too flat";
  EXPECT_FALSE(box.enters_between({1.001, 0.2, -0.03}, {1.001, 0.2, 0.03})) << "past it";
  EXPECT_FALSE(box.enters_between({0.3, 0.2, 0.01}, {0.3, 0.2, 0.01})) << "no way at all";
}

RC_GTEST_PROP(EnclosingBall, HoldsAllPointsAndNoSmallerBallDoes, (std::uint32_t seed)) {
  std::mt19937_64 random(seed);
  const auto count = static_cast<std::size_t>(1 + random() % 60);
  const bool flat = random() % 3 == 0;
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    points.push_back(random_in_box(random, {-1, -2, flat ? 0.0 : -3.0}, {1, 2, flat ? 0.0 : 3.0}));
    if (random() % 4 == 0) points.push_back(points[random() % points.size()]);
  }
  const Sphere ball = enclosing_ball(points);
  for (const Vec3& p : points) RC_ASSERT((p - ball.center_m).norm() <= ball.radius_m * (1 + 1e-14));
  // The centre of the smallest ball is the only point from which every step increases the distance to some farthest
  // point.
  const auto reach = [&](const Vec3& from) {
    double r = 0;
    for (const Vec3& p : points) r = std::max(r, (p - from).norm());
    return r;
  };
  for (const Vec3& way : even_directions(200)) {
    RC_ASSERT(reach(ball.center_m + 1e-3 * way) >= ball.radius_m * (1 - 1e-9));
  }
}

TEST(EnclosingBall, OfTheCornersOfACubeIsItsCircumsphere) {
  const Sphere ball = enclosing_ball(test::box_mesh({2, 2, 2}).vertices_m);
  EXPECT_LT(ball.center_m.norm(), 1e-12);
  EXPECT_NEAR(ball.radius_m, std::sqrt(3.0), 1e-12);
}

TEST(EnclosingBall, OfPointsOnALineIsHalfItsLengthWide) {
  std::vector<Vec3> points;
  for (int i = 0; i <= 10; ++i) points.emplace_back(0.1 * i, 0, 0);
  EXPECT_NEAR(enclosing_ball(points).radius_m, 0.5, 1e-14);
  EXPECT_EQ(enclosing_ball({}).radius_m, 0);
}

RC_GTEST_PROP(EnclosingBallOfBalls, HoldsAllBallsWithinOnePercentOfTheSmallest, (std::uint32_t seed)) {
  std::mt19937_64 random(seed);
  std::vector<Sphere> balls;
  for (std::size_t i = 0; i < 1 + random() % 20; ++i) {
    balls.push_back({random_in_box(random, {-1, -1, -1}, {1, 1, 1}), 0.1 + test::uniform(random)});
  }
  const Sphere ball = enclosing_ball_of_balls(balls);
  for (const Sphere& b : balls)
    RC_ASSERT((b.center_m - ball.center_m).norm() + b.radius_m <= ball.radius_m * (1 + 1e-14));
  // The reach of any point is an upper bound; a fine grid around the result must not find one that is much smaller.
  for (const Vec3& way : even_directions(200)) {
    for (const double step : {0.01, 0.05, 0.2}) {
      double reach = 0;
      for (const Sphere& b : balls)
        reach = std::max(reach, (b.center_m - ball.center_m - step * way).norm() + b.radius_m);
      RC_ASSERT(reach >= 0.99 * ball.radius_m);
    }
  }
}

}  // namespace
}  // namespace poise::geometry
