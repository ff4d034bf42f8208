// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "geometry/enclosing_ball.h"
#include "geometry/sampling.h"
#include "geometry/triangle_bvh.h"
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
  for (int i = 0; i < 300; ++i) {
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
  // The centre of the smallest ball is the one place from which every step is away from some farthest point.
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
  for (const Sphere& b : balls) RC_ASSERT((b.center_m - ball.center_m).norm() + b.radius_m <= ball.radius_m * (1 + 1e-14));
  // Any point's reach is an upper bound; a fine raster around the answer must not find one that is much smaller.
  for (const Vec3& way : even_directions(200)) {
    for (const double step : {0.01, 0.05, 0.2}) {
      double reach = 0;
      for (const Sphere& b : balls) reach = std::max(reach, (b.center_m - ball.center_m - step * way).norm() + b.radius_m);
      RC_ASSERT(reach >= 0.99 * ball.radius_m);
    }
  }
}

}  // namespace
}  // namespace poise::geometry
