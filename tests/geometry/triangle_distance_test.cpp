// SPDX-License-Identifier: MIT
#include "geometry/primitives/triangle_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/bvh/ball_tree.h"
#include "geometry/bvh/triangle_bvh.h"

namespace poise::geometry {
namespace {

struct Dice {
  std::mt19937_64 bits{3};
  double unit() { return static_cast<double>(bits() >> 11U) * 0x1.0p-53; }
  Vec3 in_box(double half) { return half * Vec3(2 * unit() - 1, 2 * unit() - 1, 2 * unit() - 1); }
  TriangleCorners triangle(double half, double size) {
    const Vec3 at = in_box(half);
    return {at + in_box(size), at + in_box(size), at + in_box(size)};
  }
};

const TriangleCorners kFloor = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)};

TEST(TriangleDistance, OfACornerOverAFaceIsItsHeight) {
  const TriangleCorners above = {Vec3(1, 1, 0.25), Vec3(1.5, 1, 2), Vec3(1, 1.5, 2)};
  EXPECT_NEAR(distance_of_triangles_m(kFloor, above), 0.25, 1e-15);
  EXPECT_NEAR(distance_of_triangles_m(above, kFloor), 0.25, 1e-15);
}

TEST(TriangleDistance, OfTwoCrossedEdgesIsTheirGap) {
  // The ridge along x at height 1 crosses below the ridge along y at height 1.125.
  const TriangleCorners lower = {Vec3(-1, 0, 1), Vec3(1, 0, 1), Vec3(0, 0, -3)};
  const TriangleCorners upper = {Vec3(0, -1, 1.125), Vec3(0, 1, 1.125), Vec3(0, 0, 5)};
  EXPECT_NEAR(distance_of_triangles_m(lower, upper), 0.125, 1e-15);
}

TEST(TriangleDistance, IsZeroWhereAnEdgePassesThroughTheFaceFarFromAllCorners) {
  const TriangleCorners pierced = {Vec3(1, 1, -2), Vec3(1, 1, 2), Vec3(1, -50, 0)};
  EXPECT_EQ(distance_of_triangles_m(kFloor, pierced), 0);
  EXPECT_EQ(distance_of_triangles_m(pierced, kFloor), 0);
}

TEST(TriangleDistance, KnowsTrianglesWithoutAreaByTheirEdges) {
  const TriangleCorners needle = {Vec3(1, 1, 0.5), Vec3(1, 1, 1), Vec3(1, 1, 2)};
  EXPECT_NEAR(distance_of_triangles_m(kFloor, needle), 0.5, 1e-15);
  const TriangleCorners point = {Vec3(-3, -4, 0), Vec3(-3, -4, 0), Vec3(-3, -4, 0)};
  EXPECT_NEAR(distance_of_triangles_m(kFloor, point), 5, 1e-15);
}

// Alternating projections between two convex sets converge to their distance (Cheney and Goldstein 1959).
double by_projections(const TriangleCorners& s, const TriangleCorners& t) {
  Vec3 q = (t[0] + t[1] + t[2]) / 3;
  Vec3 p = q;
  for (int i = 0; i < 4000; ++i) {
    p = closest_on_triangle(q, s);
    const Vec3 next = closest_on_triangle(p, t);
    if ((next - q).norm() < 1e-15) break;
    q = next;
  }
  return (p - q).norm();
}

TEST(TriangleDistance, AgreesWithProjectionsBackAndForth) {
  Dice dice;
  int apart = 0;
  for (int i = 0; i < 600; ++i) {
    const TriangleCorners s = dice.triangle(1, 0.8);
    const TriangleCorners t = dice.triangle(1, 0.8);
    const double found = distance_of_triangles_m(s, t);
    const double expected = by_projections(s, t);
    // The projections converge from above, and slowly if the triangles meet at a small angle.
    EXPECT_LE(found, expected + 1e-12) << i;
    EXPECT_GE(found, expected - 2e-3) << i;
    if (found > 0) ++apart;
  }
  EXPECT_GT(apart, 300);
  EXPECT_LT(apart, 590);
}

TEST(SegmentAndTriangle, MeetOnlyWithinTheTriangleAndTheSegment) {
  EXPECT_TRUE(segment_meets_triangle(Vec3(1, 1, 1), Vec3(1, 1, -1), kFloor));
  EXPECT_TRUE(segment_meets_triangle(Vec3(1, 1, -1), Vec3(1, 1, 1), kFloor));
  EXPECT_TRUE(segment_meets_triangle(Vec3(2, 0, 1), Vec3(2, 0, -1), kFloor)) << "on its border";
  EXPECT_FALSE(segment_meets_triangle(Vec3(3, 3, 1), Vec3(3, 3, -1), kFloor)) << "beside it";
  EXPECT_FALSE(segment_meets_triangle(Vec3(1, 1, 2), Vec3(1, 1, 1), kFloor)) << "too short";
  EXPECT_FALSE(segment_meets_triangle(Vec3(-1, 1, 0), Vec3(5, 1, 0), kFloor)) << "in its plane";
}

TEST(BallTree, FindsEveryBallThatASegmentMeets) {
  Dice dice;
  std::vector<Sphere> balls;
  for (int i = 0; i < 300; ++i) balls.push_back({dice.in_box(2), 0.02 + 0.2 * dice.unit()});
  balls.push_back(balls.front());
  const BallTree tree(balls);
  for (int i = 0; i < 100; ++i) {
    const Vec3 from = dice.in_box(3);
    const Vec3 to = dice.in_box(3);
    std::vector<int> seen(balls.size(), 0);
    EXPECT_FALSE(tree.any_along(from, to, [&](std::uint32_t ball) {
      ++seen[ball];
      return false;
    }));
    for (std::size_t k = 0; k < balls.size(); ++k) {
      EXPECT_LE(seen[k], 1);
      const bool meets = distance_to_segment_m(balls[k].center_m, from, to) <= balls[k].radius_m;
      EXPECT_TRUE(!meets || seen[k] == 1) << k;
    }
  }
  EXPECT_FALSE(BallTree().any_along(Vec3::Zero(), Vec3::UnitX(), [](std::uint32_t) { return true; }));
}

TEST(BallTree, HoldsAllBallsBelowANodeInItsBall) {
  Dice dice;
  std::vector<Sphere> balls;
  for (int i = 0; i < 77; ++i) balls.push_back({dice.in_box(2), 0.3 * dice.unit()});
  const BallTree tree(balls);
  std::size_t in_leaves = 0;
  for (const BallTree::Node& node : tree.nodes()) {
    if (node.leaf()) in_leaves += node.end - node.begin;
    for (std::uint32_t place = node.begin; place < node.end; ++place) {
      const Sphere& ball = balls[tree.order()[place]];
      EXPECT_LE((ball.center_m - node.center_m).norm() + ball.radius_m, node.radius_m);
    }
  }
  EXPECT_EQ(in_leaves, balls.size());
}

}  // namespace
}  // namespace poise::geometry
