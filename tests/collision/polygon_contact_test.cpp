// SPDX-License-Identifier: MIT
#include "collision/triangles/polygon_contact.h"
#include "collision/instruction_sets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "collision/polygon_pairs.h"
#include "collision/triangles/convex_gap.h"
#include "collision/triangles/surface_descent.h"
#include "collision/triangles/true_surface.h"
#include "geometry/mesh/procedural.h"

namespace poise::collision {
namespace {

using test::box_mesh;

constexpr double kQuarter = std::numbers::pi / 4;

const Shape& box() {
  static const ShapePtr shape = mesh_shape(box_mesh(Vec3(1, 1, 1)));
  return *shape;
}
const Shape& slab() {
  static const ShapePtr shape = mesh_shape(box_mesh(Vec3(3, 3, 0.5)));
  return *shape;
}
const Shape& ball() {
  static const ShapePtr shape = make_sphere_shape(0.25).value();
  return *shape;
}

void expect_near(const Vec3& is, const Vec3& wanted, double tolerance) {
  EXPECT_LT((is - wanted).norm(), tolerance) << is.transpose() << " instead of " << wanted.transpose();
}

TEST(Polygons, ACornerOverAFaceHasTheFacesNormalAndItsOwnPlace) {
  const double corner = std::sqrt(0.75);
  for (const double gap : {0.03, 1e-3, 1e-6, -1e-6, -1e-3, -0.03}) {
    const Vec3 offset(0.2, -0.3, 0.25 + corner + gap);
    const PairContact contact = solve_by_polygons(slab(), box(), on_its_corner(), offset, 0.05).contact;
    ASSERT_TRUE(contact.present) << gap;
    expect_near(contact.direction, Vec3::UnitZ(), 1e-6);
    EXPECT_NEAR(contact.estimated_separation_m, gap, 1e-8);
    EXPECT_EQ(contact.estimated_separation_m, contact.certain_separation_m);
    EXPECT_EQ(contact.estimated_separation_m, contact.spheres_m);
    expect_near(contact.arm_m.cross(Vec3::UnitZ()), Vec3(0.2, -0.3, 0).cross(Vec3::UnitZ()),
                1e-6 + 0.1 * std::max(0.0, -gap));
    expect_near(contact.moment_a_m, contact.arm_m.cross(contact.direction), 1e-6 + 0.1 * std::max(0.0, -gap));
    expect_near(contact.moment_b_m, contact.moment_a_m - offset.cross(contact.direction), 1e-15);
  }
}

TEST(Polygons, TwoCrossedEdgesAnswerSquareToBoth) {
  const double half = std::sqrt(0.5);
  const Mat3 roof = turned(kQuarter, Vec3::UnitX());
  const Mat3 keel = turned(0.9, Vec3::UnitZ()) * turned(kQuarter, Vec3::UnitX());
  for (const double gap : {0.02, 1e-4, 1e-8, -1e-7, -1e-4, -0.02}) {
    const Vec3 offset(0.1, 0.05, 2 * half + gap);
    const PairFrame frame = make_pair_frame(box(), Pose{Vec3::Zero(), roof}, box(), Pose{offset, keel}, 0.03, 0);
    std::vector<FrontPool> pools;
    pools.emplace_back(1U << 18U);
    const PairContact contact = solve_by_polygons(frame, pools).contact;
    ASSERT_TRUE(contact.present) << gap;
    expect_near(roof * contact.direction, Vec3::UnitZ(), 1e-5);
    EXPECT_NEAR(contact.estimated_separation_m, gap, 1e-8);
    const Vec3 place = roof * contact.arm_m;
    // The edges touch where the upper one crosses the ridge y = 0.
    EXPECT_NEAR(place.y(), 0, 1e-6 + std::max(0.0, -gap));
    EXPECT_NEAR(place.z(), half + 0.5 * gap, 1e-6 + std::max(0.0, -gap));
  }
}

TEST(Polygons, AFaceOnAFaceAnswersInTheMiddleAndNotInACorner) {
  for (const double gap : {0.01, 1e-6, -1e-3}) {
    const Vec3 offset(0.31, -0.22, 0.75 + gap);
    const PairContact contact = solve_by_polygons(slab(), box(), turned(0.4, Vec3::UnitZ()), offset, 0.02).contact;
    ASSERT_TRUE(contact.present);
    expect_near(contact.direction, Vec3::UnitZ(), 1e-6);
    EXPECT_NEAR(contact.estimated_separation_m, gap, 1e-8);
    EXPECT_NEAR(contact.arm_m.x(), 0.31, 1e-3);
    EXPECT_NEAR(contact.arm_m.y(), -0.22, 1e-3);
  }
}

TEST(Polygons, BoxesInLineWithEachOtherAnswerAsAnyOthers) {
  for (const double gap : {1e-3, 0.0, -1e-3, -0.2}) {
    const PairContact contact = solve_by_polygons(box(), box(), Mat3::Identity(), Vec3(0, 0, 1 + gap), 0.01).contact;
    ASSERT_TRUE(contact.present) << gap;
    expect_near(contact.direction, Vec3::UnitZ(), 1e-6);
    EXPECT_NEAR(contact.estimated_separation_m, gap, 1e-8);
    EXPECT_LT(std::hypot(contact.arm_m.x(), contact.arm_m.y()), 1e-3);
  }
}

TEST(Polygons, ABallMeetsFacesEdgesAndCornersExactly) {
  for (const double gap : {0.01, -0.01, -0.2}) {
    PairContact contact = solve_by_polygons(box(), ball(), Mat3::Identity(), Vec3(0.1, 0.2, 0.75 + gap), 0.02).contact;
    ASSERT_TRUE(contact.present);
    expect_near(contact.direction, Vec3::UnitZ(), 1e-8);
    EXPECT_NEAR(contact.estimated_separation_m, gap, 1e-8);
    // The same with the ball first.
    contact = solve_by_polygons(ball(), box(), Mat3::Identity(), Vec3(-0.1, -0.2, -0.75 - gap), 0.02).contact;
    expect_near(contact.direction, -Vec3::UnitZ(), 1e-8);
    EXPECT_NEAR(contact.estimated_separation_m, gap, 1e-8);
    const Vec3 over_edge = Vec3(0.5, 0.1, 0.5) + (0.25 + gap) * Vec3(1, 0, 1).normalized();
    contact = solve_by_polygons(box(), ball(), Mat3::Identity(), over_edge, 0.02).contact;
    expect_near(contact.direction, Vec3(1, 0, 1).normalized(), 1e-6);
    EXPECT_NEAR(contact.estimated_separation_m, gap, 1e-8);
    const Vec3 over_corner = Vec3(0.5, 0.5, -0.5) + (0.25 + gap) * Vec3(1, 1, -1).normalized();
    contact = solve_by_polygons(box(), ball(), Mat3::Identity(), over_corner, 0.02).contact;
    expect_near(contact.direction, Vec3(1, 1, -1).normalized(), 1e-6);
    EXPECT_NEAR(contact.estimated_separation_m, gap, 1e-8);
  }
}

TEST(Polygons, ABallWhoseCentreIsInsideLeavesByTheNearestFace) {
  const PairContact contact = solve_by_polygons(box(), ball(), Mat3::Identity(), Vec3(0.1, 0.2, 0.42), 0.02).contact;
  ASSERT_TRUE(contact.present);
  expect_near(contact.direction, Vec3::UnitZ(), 1e-12);
  EXPECT_NEAR(contact.estimated_separation_m, -0.33, 1e-8);
}

TEST(Polygons, APlaneMeetsTheLowestCorners) {
  const ShapePtr floor = make_plane_shape(Vec3::UnitZ(), 0).value();
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 16U);
  for (const double gap : {0.01, -0.1}) {
    const Pose flat{Vec3(3, 4, 0.5 + gap), Mat3::Identity()};
    PairContact contact = solve_by_polygons(make_pair_frame(box(), flat, *floor, Pose{}, 0.05, 0), pools).contact;
    ASSERT_TRUE(contact.present);
    expect_near(contact.direction, -Vec3::UnitZ(), 1e-12);
    EXPECT_NEAR(contact.estimated_separation_m, gap, 1e-12);
    expect_near(contact.arm_m, Vec3(0, 0, -0.5), 1e-12);
    const Pose tip{Vec3(3, 4, std::sqrt(0.75) + gap), on_its_corner()};
    contact = solve_by_polygons(make_pair_frame(box(), tip, *floor, Pose{}, 0.05, 0), pools).contact;
    EXPECT_NEAR(contact.estimated_separation_m, gap, 1e-12);
    expect_near(contact.arm_m, Vec3(-0.5, -0.5, -0.5), 1e-9);
  }
}

TEST(Polygons, WhatIsInsideAltogetherIsPushedAndNotForgotten) {
  static const ShapePtr crumb = mesh_shape(box_mesh(Vec3(0.2, 0.2, 0.2)));
  for (const Vec3& place : {Vec3(0.1, 0, 0.05), Vec3(0.2, 0.1, 0.395)}) {
    const PairContact contact = solve_by_polygons(box(), *crumb, turned(0.3, Vec3(1, 2, 3)), place, 0.02).contact;
    ASSERT_TRUE(contact.present);
    EXPECT_LE(contact.certain_separation_m, 0);
    EXPECT_TRUE(contact.direction.allFinite());
    EXPECT_GT(contact.direction.dot(place), 0);
  }
}

TEST(Polygons, DeepAndThinOverlapsStayFinite) {
  static const ShapePtr needle = mesh_shape(box_mesh(Vec3(0.02, 0.02, 4)));
  static const ShapePtr plate = mesh_shape(box_mesh(Vec3(2, 2, 0.01)));
  std::mt19937_64 random(5);
  int present = 0;
  for (int round = 0; round < 200; ++round) {
    const Shape* shapes[] = {needle.get(), plate.get(), &box()};
    const Shape& a = *shapes[random() % 3];
    const Shape& b = *shapes[random() % 3];
    const PolygonAnswer answer =
        solve_by_polygons(a, b, random_pose(random, 0).rotation, random_vector(random, 0.5), 0.01);
    if (!answer.contact.present) continue;
    ++present;
    EXPECT_NEAR(answer.contact.direction.norm(), 1, 0.999) << "round " << round;
    EXPECT_TRUE(answer.contact.moment_a_m.allFinite() && answer.contact.moment_b_m.allFinite());
    EXPECT_TRUE(std::isfinite(answer.contact.estimated_separation_m));
    EXPECT_LT(std::abs(answer.contact.estimated_separation_m), 8);
  }
  EXPECT_GT(present, 50);
}

TEST(Polygons, PiecesOfAnySizeGiveTheSameBitsAndEndWhenTheirUnitsAreDone) {
  static const ShapePtr torus = mesh_shape(test::torus_mesh(0.5, 0.2, 30, 15));
  std::mt19937_64 random(6);
  int split = 0;
  double most = 0;
  for (int round = 0; round < 20; ++round) {
    const Mat3 turn = random_pose(random, 0).rotation;
    const Vec3 offset = random_vector(random, 0.6);
    const PolygonAnswer whole = solve_by_polygons(*torus, *torus, turn, offset, 0.01);
    const PolygonAnswer pieces = solve_by_polygons(*torus, *torus, turn, offset, 0.01, 10);
    if (pieces.quanta > 1) ++split;
    // A piece does at most one step more: the longest is the contact of surfaces that cross.
    EXPECT_LE(pieces.longest, 10 + 512) << "of " << whole.longest;
    most = std::max(most, whole.longest);
    EXPECT_EQ(whole.contact.present, pieces.contact.present);
    EXPECT_EQ(whole.contact.direction, pieces.contact.direction);
    EXPECT_EQ(whole.contact.moment_a_m, pieces.contact.moment_a_m);
    EXPECT_EQ(whole.contact.estimated_separation_m, pieces.contact.estimated_separation_m);
  }
  EXPECT_GT(split, 10);
  EXPECT_GT(most, 2000) << "nothing to cut";
}

using Found = std::vector<SurfaceDescent::Candidate>;

Found descend(const PlacedSurface& on_a, const PlacedSurface& on_b, const SurfaceReach& reach) {
  Found found;
  SurfaceDescent descent;
  descent.begin(on_a, on_b);
  for (SurfaceDescent::Step step = descent.step(reach); step != SurfaceDescent::Step::Done;
       step = descent.step(reach)) {
    if (step != SurfaceDescent::Step::Triangles) continue;
    found.insert(found.end(), descent.candidates().begin(), descent.candidates().end());
  }
  return found;
}

// What a pair of triangles must be found for.
SurfaceDescent::Candidate wanted(const PlacedSurface& on_a, std::uint32_t i, const PlacedSurface& on_b, std::uint32_t j,
                                 const SurfaceReach& reach) {
  PlacedTriangle a;
  PlacedTriangle b;
  place(on_a, i, a);
  place(on_b, j, b);
  const PlaneSides sides = plane_sides(a, b);
  FeatureList features;
  const std::size_t count = facing_features(on_a, a, on_b, b, sides, reach.apart_m, features, reach.beneath_m);
  return {i, j, crossing(a, b, sides).has_value(), count > 0};
}

TEST(Polygons, TheDescentFindsEveryPairOfTrianglesThatCrossesOrHasFacingFeaturesOnce) {
  static const ShapePtr torus = mesh_shape(test::torus_mesh(0.5, 0.2, 16, 8));
  static const ShapePtr needle = mesh_shape(box_mesh(Vec3(0.02, 0.02, 4)));
  static const ShapePtr bowl = mesh_shape(geometry::make_procedural_shape("bowl", 2).value(), 2);
  std::mt19937_64 random(9);
  std::size_t crossing_pairs = 0;
  std::size_t facing_pairs = 0;
  std::size_t candidates = 0;
  std::size_t all = 0;
  for (int round = 0; round < 60; ++round) {
    const ShapeSurface& a = *torus->surface;
    const ShapeSurface& b = round % 3 == 0 ? a : *(round % 3 == 1 ? needle : bowl)->surface;
    const PlacedSurface on_a{&a, Mat3::Identity(), Vec3::Zero()};
    const PlacedSurface on_b{&b, random_pose(random, 0).rotation, random_vector(random, 0.8)};
    // Boxes are compared up to `apart_m`; a corner beneath a face may lie past its rim by twice its depth.
    const double apart_m = uniform(random, 0, 0.1);
    const SurfaceReach reach{apart_m, uniform(random, 0, apart_m / 3)};
    const Found found = descend(on_a, on_b, reach);
    std::vector<const SurfaceDescent::Candidate*> of(a.triangles.size() * b.triangles.size(), nullptr);
    for (const SurfaceDescent::Candidate& c : found) {
      const std::size_t pair = c.a * b.triangles.size() + c.b;
      ASSERT_EQ(of[pair], nullptr) << "found twice";
      of[pair] = &c;
    }
    candidates += found.size();
    all += of.size();
    for (std::uint32_t i = 0; i < a.triangles.size(); ++i) {
      for (std::uint32_t j = 0; j < b.triangles.size(); ++j) {
        const SurfaceDescent::Candidate want = wanted(on_a, i, on_b, j, reach);
        const SurfaceDescent::Candidate* const got = of[i * b.triangles.size() + j];
        const bool crosses = got != nullptr && got->may_cross;
        const bool faces = got != nullptr && got->may_face;
        ASSERT_TRUE(crosses || !want.may_cross) << "round " << round;
        ASSERT_TRUE(faces || !want.may_face) << "round " << round;
        crossing_pairs += want.may_cross ? 1U : 0U;
        facing_pairs += want.may_face ? 1U : 0U;
      }
    }
  }
  EXPECT_GT(crossing_pairs, 500U);
  EXPECT_GT(facing_pairs, 500U);
  EXPECT_LT(candidates, 8 * (crossing_pairs + facing_pairs)) << "of " << all;
}

TEST(Polygons, TheDescentIsTheSameOnEveryInstructionSet) {
  static const ShapePtr torus = mesh_shape(test::torus_mesh(0.5, 0.2, 30, 15));
  std::mt19937_64 random(12);
  std::size_t candidates = 0;
  for (int round = 0; round < 20; ++round) {
    const PlacedSurface on_a{torus->surface.get(), Mat3::Identity(), Vec3::Zero()};
    const PlacedSurface on_b{torus->surface.get(), random_pose(random, 0).rotation, random_vector(random, 0.6)};
    const SurfaceReach reach{uniform(random, 0, 0.02), uniform(random, 0, 0.01)};
    const Found expected = descend(on_a, on_b, reach);
    candidates += expected.size();
    on_every_instruction_set([&](const char* name) {
      const Found found = descend(on_a, on_b, reach);
      ASSERT_EQ(found.size(), expected.size()) << name;
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].a, expected[i].a) << name;
        EXPECT_EQ(found[i].b, expected[i].b) << name;
        EXPECT_EQ(found[i].may_cross, expected[i].may_cross) << name;
        EXPECT_EQ(found[i].may_face, expected[i].may_face) << name;
      }
    });
  }
  EXPECT_GT(candidates, 1000U);
}

TEST(Polygons, SurfacesThatDoNotCrossHaveNoPenetratingContactPoints) {
  // Where the side of a bowl is touched beside its rim, edges pass each other that do not overlap.
  static const ShapePtr bowl = mesh_shape(geometry::make_procedural_shape("bowl", 2).value(), 2);
  const TrueSurface surface = true_surface_of(*bowl);
  std::mt19937_64 random(10);
  int touches = 0;
  std::size_t points = 0;
  for (int round = 0; round < 150; ++round) {
    const Mat3 turn = random_pose(random, 0).rotation;
    const Vec3 direction = random_pose(random, 0).rotation.col(0);
    Vec3 offset = 2 * direction + random_vector(random, 0.3);
    double distance = 1;
    for (int step = 0; step < 200 && distance > 1e-5; ++step) {
      distance = surface_distance_m(surface, Pose{}, surface, Pose{offset, turn}, 10);
      offset -= distance * direction;
    }
    if (distance > 1e-5) continue;
    offset += 1e-5 * direction;
    const PolygonAnswer answer = solve_by_polygons(*bowl, *bowl, turn, offset, 0.03);
    if (!answer.contact.present || answer.sums.crossed) continue;
    ++touches;
    points += answer.level.manifold_points.count;
    for (std::size_t i = 0; i < answer.level.manifold_points.count; ++i) {
      EXPECT_GT(answer.level.manifold_points.point[i].certain_separation_m, -1e-5) << "round " << round;
    }
  }
  EXPECT_GT(touches, 20);
  EXPECT_GT(points, 40U);
}

TEST(Polygons, CurvesOfACrossingCloseHoweverManyTrianglesMeet) {
  static const ShapePtr torus = mesh_shape(test::torus_mesh(0.5, 0.2, 48, 24));
  std::mt19937_64 random(7);
  int crossed = 0;
  std::uint32_t most = 0;
  for (int round = 0; round < 30; ++round) {
    const PolygonSums sums =
        solve_by_polygons(*torus, *torus, random_pose(random, 0).rotation, random_vector(random, 0.4), 1e-3).sums;
    if (!sums.crossed) continue;
    ++crossed;
    most = std::max(most, sums.segments);
    EXPECT_LT(sums.open_m.norm(), 1e-12 * sums.length_m) << "round " << round << ", " << sums.segments << " segments";
  }
  EXPECT_GT(crossed, 15);
  EXPECT_GT(most, 300U);
}

TEST(Polygons, TwoBallsOfTrianglesAnswerAsBalls) {
  static const ShapePtr round = mesh_shape(test::ball_mesh(0.5, 3));
  std::mt19937_64 random(8);
  for (int i = 0; i < 30; ++i) {
    const Vec3 between = random_pose(random, 0).rotation.col(0);
    const double gap = uniform(random, -0.05, 0.01);
    const PairContact contact =
        solve_by_polygons(*round, *round, random_pose(random, 0).rotation, (1 + gap) * between, 0.02).contact;
    ASSERT_TRUE(contact.present);
    EXPECT_NEAR(contact.estimated_separation_m, gap, 1.5e-2);
    EXPECT_GT(contact.direction.dot(between), std::cos(0.12)) << gap;
  }
}

}  // namespace
}  // namespace poise::collision
