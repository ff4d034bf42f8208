// SPDX-License-Identifier: MIT
#include "collision/triangles/triangle_pair.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collision/shapes.h"
#include "collision/triangles/polygon_contact.h"

namespace poise::collision {
namespace {

using geometry::TriangleCorners;

// One triangle as a surface: both of its sides are outside, and it owns all of its corners and sides.
ShapeSurface sheet(const TriangleCorners& corners) {
  TriangleMesh mesh;
  mesh.vertices_m.assign(corners.begin(), corners.end());
  mesh.triangles = {{0, 1, 2}};
  const Sphere around{Vec3::Zero(), 1e3};
  return geometry::make_surface(mesh, Vec3::Zero(), Solidity::Shell, tree_of_spheres({&around, 1}).value());
}

struct TwoSheets {
  ShapeSurface surface_a, surface_b;
  PlacedSurface on_a, on_b;
  PlacedTriangle a, b;

  TwoSheets(const TriangleCorners& first, const TriangleCorners& second)
      : surface_a(sheet(first)), surface_b(sheet(second)) {
    on_a.surface = &surface_a;
    on_b.surface = &surface_b;
    place(on_a, 0, a);
    place(on_b, 0, b);
  }
  [[nodiscard]] std::optional<CrossingSegment> cross() const { return crossing(a, b, plane_sides(a, b)); }
  std::vector<FacingFeatures> facing() const {
    FeatureList list;
    const std::size_t count = facing_features(on_a, a, on_b, b, plane_sides(a, b), 1e3, list);
    return {list.begin(), list.begin() + static_cast<std::ptrdiff_t>(count)};
  }
};

// The distance of two triangles by alternating projections between them, from several starts. Both are convex, so this
// converges, and the result is never below the distance.
double slow_distance(const TriangleCorners& a, const TriangleCorners& b) {
  double least = 1e300;
  for (std::size_t start = 0; start < 3; ++start) {
    Vec3 on_b = b[start];
    Vec3 on_a = a[0];
    for (int step = 0; step < 3000; ++step) {
      on_a = geometry::closest_on_triangle(on_b, a);
      on_b = geometry::closest_on_triangle(on_a, b);
    }
    least = std::min(least, (on_b - on_a).norm());
  }
  return least;
}

TriangleCorners random_triangle(std::mt19937_64& random, const Vec3& near) {
  TriangleCorners t;
  for (Vec3& corner : t) corner = near + random_vector(random, 1);
  // Some triangles are needles.
  if (random() % 4 == 0) t[2] = t[0] + 0.5 * (t[1] - t[0]) + 0.01 * (t[2] - t[0]);
  return t;
}

TEST(TrianglePair, FacingFeaturesFindTheDistanceThatASlowSearchFinds) {
  std::mt19937_64 random(31);
  int apart = 0;
  int crossed = 0;
  for (int round = 0; round < 500; ++round) {
    const TriangleCorners first = random_triangle(random, Vec3::Zero());
    const TriangleCorners second = random_triangle(random, random_vector(random, 1.2));
    const TwoSheets pair(first, second);
    const double slow = slow_distance(first, second);
    if (pair.cross()) {
      ++crossed;
      EXPECT_LT(slow, 2e-2) << "round " << round;
      continue;
    }
    const std::vector<FacingFeatures> facing = pair.facing();
    ASSERT_FALSE(facing.empty()) << "round " << round;
    double least = 1e300;
    for (const FacingFeatures& f : facing) {
      least = std::min(least, f.gap_m);
      EXPECT_NEAR(f.normal.norm(), 1, 1e-12);
      EXPECT_NEAR((f.point_b_m - f.point_a_m - f.gap_m * f.normal).norm(), 0, 1e-9);
      EXPECT_LT((geometry::closest_on_triangle(f.point_a_m, first) - f.point_a_m).norm(), 1e-9);
      EXPECT_LT((geometry::closest_on_triangle(f.point_b_m, second) - f.point_b_m).norm(), 1e-9);
    }
    ++apart;
    EXPECT_LE(least, slow + 1e-9) << "round " << round;
    EXPECT_GE(least, slow - 2e-2) << "round " << round;
  }
  EXPECT_GT(apart, 150);
  EXPECT_GT(crossed, 20);
}

TEST(TrianglePair, ACrossingLiesInBothTriangles) {
  std::mt19937_64 random(32);
  int crossed = 0;
  for (int round = 0; round < 3000; ++round) {
    const TriangleCorners first = random_triangle(random, Vec3::Zero());
    const TriangleCorners second = random_triangle(random, random_vector(random, 0.5));
    const TwoSheets pair(first, second);
    const auto segment = pair.cross();
    if (!segment) continue;
    ++crossed;
    for (const Vec3& end : {segment->from_m, segment->to_m}) {
      EXPECT_LT((geometry::closest_on_triangle(end, first) - end).norm(), 1e-9) << "round " << round;
      EXPECT_LT((geometry::closest_on_triangle(end, second) - end).norm(), 1e-9) << "round " << round;
    }
    EXPECT_GE(pair.a.normal.cross(pair.b.normal).dot(segment->to_m - segment->from_m), 0);
  }
  EXPECT_GT(crossed, 300);
}

TEST(TrianglePair, TrianglesWithoutAreaOrInOnePlaneGiveFiniteAnswers) {
  const TriangleCorners flat{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  const TriangleCorners same_plane{Vec3(0.2, 0.2, 0), Vec3(1.2, 0.2, 0), Vec3(0.2, 1.2, 0)};
  const TriangleCorners line{Vec3(0.2, 0.2, 0.5), Vec3(0.3, 0.2, 0.5), Vec3(0.4, 0.2, 0.5)};
  const TriangleCorners point{Vec3(0.2, 0.2, 0.5), Vec3(0.2, 0.2, 0.5), Vec3(0.2, 0.2, 0.5)};
  for (const TriangleCorners& other : {flat, same_plane, line, point}) {
    const TwoSheets pair(flat, other);
    for (const FacingFeatures& f : pair.facing()) {
      EXPECT_TRUE(std::isfinite(f.gap_m) && f.normal.allFinite() && f.point_a_m.allFinite() && f.point_b_m.allFinite());
    }
    const auto segment = pair.cross();
    if (!segment) continue;
    EXPECT_TRUE(segment->from_m.allFinite() && segment->to_m.allFinite());
  }
  ASSERT_FALSE(TwoSheets(flat, line).facing().empty());
  EXPECT_NEAR(TwoSheets(flat, line).facing().front().gap_m, 0.5, 1e-15);
}

TEST(TrianglePair, PairsThatWereMetAreKnownAndThoseWithoutRoomStayUnknown) {
  MetPairs met;
  std::uint32_t taken = 0;
  while (met.meet(taken, taken * 7) == MetPairs::Answer::New) ++taken;
  EXPECT_GT(taken, 500U);
  for (std::uint32_t i = 0; i < taken; ++i) EXPECT_EQ(met.meet(i, i * 7), MetPairs::Answer::Met);
  EXPECT_EQ(met.meet(taken, taken * 7), MetPairs::Answer::NoRoom);
  EXPECT_EQ(met.meet(taken, taken * 7), MetPairs::Answer::NoRoom);
}

}  // namespace
}  // namespace poise::collision
