// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <random>
#include <vector>

#include "collision/polygon_pairs.h"
#include "collision/triangles/polygon_contact.h"
#include "collision/triangles/true_surface.h"

namespace poise::collision {
namespace {

using test::box_mesh;

constexpr double kPi = std::numbers::pi;
constexpr double kMargin = 6e-3;

const Shape& cube() {
  static const ShapePtr shape = mesh_shape(box_mesh(Vec3(1, 1, 1)), 1);
  return *shape;
}
const Shape& slab() {
  static const ShapePtr shape = mesh_shape(box_mesh(Vec3(3, 3, 0.5)), 1);
  return *shape;
}
const Shape& brick() {
  static const ShapePtr shape = mesh_shape(box_mesh(Vec3(3, 1, 0.5)), 1);
  return *shape;
}

/// A slab whose top and bottom faces are `n` x `n` squares of two triangles each; the sides are fans.
TriangleMesh gridded_slab(int n) {
  TriangleMesh mesh;
  const auto at = [n](int level, int i, int k) {
    return static_cast<std::uint32_t>((level * (n + 1) + i) * (n + 1) + k);
  };
  for (int level = 0; level < 2; ++level) {
    for (int i = 0; i <= n; ++i) {
      for (int k = 0; k <= n; ++k)
        mesh.vertices_m.emplace_back(3.0 * i / n - 1.5, 3.0 * k / n - 1.5, 0.5 * level - 0.25);
    }
  }
  const auto quad = [&mesh](std::uint32_t p, std::uint32_t q, std::uint32_t r, std::uint32_t s) {
    mesh.triangles.push_back({p, q, r});
    mesh.triangles.push_back({p, r, s});
  };
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      quad(at(1, i, k), at(1, i + 1, k), at(1, i + 1, k + 1), at(1, i, k + 1));
      quad(at(0, i, k), at(0, i, k + 1), at(0, i + 1, k + 1), at(0, i + 1, k));
    }
    quad(at(0, i, 0), at(0, i + 1, 0), at(1, i + 1, 0), at(1, i, 0));
    quad(at(0, i + 1, n), at(0, i, n), at(1, i, n), at(1, i + 1, n));
    quad(at(0, 0, i + 1), at(0, 0, i), at(1, 0, i), at(1, 0, i + 1));
    quad(at(0, n, i), at(0, n, i + 1), at(1, n, i + 1), at(1, n, i));
  }
  return mesh;
}

/// A block of 2 x 4 x 1 with a right-angled groove along y in its top, as wide as the block.
TriangleMesh groove_mesh() {
  TriangleMesh mesh;
  const std::vector<std::array<double, 2>> outline = {{-1.2, -1.5}, {1.2, -1.5}, {1.2, 1}, {1, 1},
                                                      {0, 0},       {-1, 1},     {-1.2, 1}};
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const double y : {-2.0, 2.0}) {
    for (const auto& [x, z] : outline) mesh.vertices_m.emplace_back(x, y, z);
  }
  // All corners are visible from the bottom of the groove, so a fan around it is valid.
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    if (i != 4 && next != 4) {
      mesh.triangles.push_back({4, i, next});
      mesh.triangles.push_back({n + 4, n + next, n + i});
    }
    mesh.triangles.push_back({i, n + i, n + next});
    mesh.triangles.push_back({i, n + next, next});
  }
  return mesh;
}

ManifoldPoints manifold_points(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                               double margin = kMargin) {
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 16U);
  return solve_by_polygons(make_pair_frame(a, pose_a, b, pose_b, margin, 0), pools).level.manifold_points;
}
ManifoldPoints manifold_points(const Shape& a, const Shape& b, const Mat3& turn, const Vec3& offset,
                               double margin = kMargin) {
  return manifold_points(a, Pose{}, b, Pose{offset, turn}, margin);
}

/// Expects a contact point at each of these points, and no others.
void expect_points(const ManifoldPoints& set, std::initializer_list<Vec3> wanted, const Vec3& normal, double gap,
                   double tolerance = 1e-6) {
  EXPECT_EQ(set.count, wanted.size());
  for (const Vec3& place : wanted) {
    EXPECT_TRUE(
        std::ranges::any_of(set.all(), [&](const ManifoldPoint& p) { return (p.point_m - place).norm() < tolerance; }))
        << "nothing at " << place.transpose() << ", gap " << gap;
  }
  for (const ManifoldPoint& p : set.all()) {
    EXPECT_LT((p.normal - normal).norm(), 1e-6) << p.normal.transpose();
    EXPECT_NEAR(p.gap_m, gap, 1e-8);
    EXPECT_EQ(p.certain_separation_m, p.gap_m);
  }
}

constexpr std::array<double, 7> kGaps = {1e-3, 1e-5, 1e-6, 0, -1e-6, -1e-5, -1e-3};

TEST(PolygonPoints, ABoxInLineWithAnotherStandsOnItsFourCorners) {
  for (const double gap : kGaps) {
    const double z = 0.5 + 0.5 * gap;
    expect_points(manifold_points(cube(), cube(), Mat3::Identity(), Vec3(0, 0, 1 + gap)),
                  {Vec3(-0.5, -0.5, z), Vec3(0.5, -0.5, z), Vec3(-0.5, 0.5, z), Vec3(0.5, 0.5, z)}, Vec3::UnitZ(), gap);
  }
}

TEST(PolygonPoints, ATurnedBoxStandsOnTheRimOfWhatBothCover) {
  for (const double gap : kGaps) {
    const ManifoldPoints set = manifold_points(cube(), cube(), turned(kPi / 6, Vec3::UnitZ()), Vec3(0, 0, 1 + gap));
    ASSERT_EQ(set.count, 4U);
    Vec3 middle = Vec3::Zero();
    for (const ManifoldPoint& p : set.all()) {
      // Sides of the lower cube are crossed by those of the upper one, 0.2887 from their middles.
      EXPECT_NEAR(p.point_m.cwiseAbs().maxCoeff(), 0.5 + 0.5 * std::max(gap, 0.0), 1e-6);
      EXPECT_NEAR(std::min(std::abs(p.point_m.x()), std::abs(p.point_m.y())), 0.5 / std::sqrt(3), 1e-6);
      EXPECT_NEAR(p.gap_m, gap, 1e-8);
      EXPECT_LT((p.normal - Vec3::UnitZ()).norm(), 1e-6);
      middle += 0.25 * p.point_m;
    }
    EXPECT_LT(middle.head<2>().norm(), 1e-6);
  }
}

TEST(PolygonPoints, ABoxThatHangsOverStandsOnWhatIsBeneathIt) {
  for (const double gap : kGaps) {
    const double z = 0.5 + 0.5 * gap;
    expect_points(manifold_points(cube(), cube(), Mat3::Identity(), Vec3(0.7, 0.1, 1 + gap)),
                  {Vec3(0.2, -0.4, z), Vec3(0.5, -0.4, z), Vec3(0.2, 0.5, z), Vec3(0.5, 0.5, z)}, Vec3::UnitZ(), gap);
  }
}

// Twice the area around points on a horizontal face, in any order.
double twice_area_of(std::vector<Vec3> points) {
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : points) middle += p / static_cast<double>(points.size());
  const auto angle = [&](const Vec3& p) { return std::atan2(p.y() - middle.y(), p.x() - middle.x()); };
  std::sort(points.begin(), points.end(), [&](const Vec3& p, const Vec3& q) { return angle(p) < angle(q); });
  double area = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    area += (points[i] - middle).cross(points[(i + 1) % points.size()] - middle).z();
  return area;
}

TEST(PolygonPoints, ASlightTiltLeavesTheSamePlacesWithGapsOfTheirOwn) {
  // Where the faces overlap: two of these six are near each other at either end of the short side.
  const std::vector<Vec3> places = {Vec3(0.4523, -0.5, 0.5), Vec3(0.5, -0.4852, 0.5),    Vec3(0.5, 0.5, 0.5),
                                    Vec3(0.3012, 0.5, 0.5),  Vec3(0.07457, 0.4299, 0.5), Vec3(0.3622, -0.5, 0.5)};
  std::mt19937_64 random(9);
  for (int round = 0; round < 40; ++round) {
    Vec3 axis = random_vector(random, 1);
    axis.z() = 0;
    const double tilt = uniform(random, -3e-3, 3e-3);
    const Mat3 turn = turned(tilt, axis) * turned(0.3, Vec3::UnitZ());
    // The lowest corner is 0.1 mm below the face; the bottom of the upper cube is a plane.
    double lowest = 0;
    for (const Vec3& corner : cube().surface->vertices_m) lowest = std::min(lowest, (turn * corner).z());
    const Vec3 offset(0.7, 0.1, 0.5 - lowest - 1e-4);
    const Vec3 down = -turn.col(2);
    const ManifoldPoints set = manifold_points(cube(), cube(), turn, offset, 0.02);
    ASSERT_EQ(set.count, 4U) << round;
    std::vector<Vec3> found;
    for (const ManifoldPoint& p : set.all()) {
      const double height = down.dot(Vec3(p.point_m.x(), p.point_m.y(), 0.5) - offset) - 0.5;
      EXPECT_NEAR(p.gap_m, height, 2e-5) << round;
      EXPECT_GT(p.normal.z(), 0.999);
      EXPECT_TRUE(std::ranges::any_of(places, [&](const Vec3& q) { return (p.point_m - q).norm() < 3e-3; })) << round;
      found.push_back(p.point_m);
    }
    // Those that touch count more, so that some of the area may be missing.
    EXPECT_GT(twice_area_of(found), 0.75 * twice_area_of(places)) << round;
  }
}

TEST(PolygonPoints, TheDepthAlongALeaningMeanIsNoPlaceBesideCornersThatAreKnown) {
  // Nearly flush on three sides. The gradient of the overlap is tilted, and along it the bodies seem to overlap twice
  // as deeply.
  static const ShapePtr block = mesh_shape(box_mesh(Vec3(1, 0.6, 0.3)), 0);
  const Quat turn(0.99999993879426841, 0.00030812565810401982, 2.6843832770291165e-05, 0.00016355258168767556);
  const Vec3 offset(-3.1650089332274594e-07, -0.29207078704036116, 0.29963948030765702);
  const ManifoldPoints set = manifold_points(*block, *block, turn.toRotationMatrix(), offset, 4e-3);
  ASSERT_EQ(set.count, 4U);
  for (const ManifoldPoint& p : set.all()) {
    EXPECT_GT(p.gap_m, -4e-4);
    EXPECT_NEAR(std::abs(p.point_m.x()), 0.5, 2e-4);
  }
}

TEST(PolygonPoints, BricksLaidAcrossEachOtherMeetWhereTheirRimsCross) {
  for (const double gap : kGaps) {
    const double z = 0.25 + 0.5 * gap;
    expect_points(manifold_points(brick(), brick(), turned(kPi / 2, Vec3::UnitZ()), Vec3(0.2, 0.1, 0.5 + gap)),
                  {Vec3(-0.3, -0.5, z), Vec3(0.7, -0.5, z), Vec3(-0.3, 0.5, z), Vec3(0.7, 0.5, z)}, Vec3::UnitZ(), gap);
  }
}

TEST(PolygonPoints, TrianglesWithinAFaceAreNoFeatures) {
  static const ShapePtr fine = mesh_shape(gridded_slab(9), 1);
  for (const double gap : {1e-5, -1e-5}) {
    const double z = 0.25 + 0.5 * gap;
    const auto turn = turned(0.3, Vec3::UnitZ());
    const ManifoldPoints coarse = manifold_points(slab(), cube(), turn, Vec3(0.31, 0.17, 0.75 + gap));
    const ManifoldPoints set = manifold_points(*fine, cube(), turn, Vec3(0.31, 0.17, 0.75 + gap));
    ASSERT_EQ(coarse.count, 4U);
    for (const ManifoldPoint& p : coarse.all()) {
      EXPECT_TRUE(std::ranges::any_of(set.all(),
                                      [&](const ManifoldPoint& q) { return (p.point_m - q.point_m).norm() < 1e-8; }));
    }
    // Two of them, shifted relative to each other.
    expect_points(manifold_points(*fine, *fine, Mat3::Identity(), Vec3(0.5, 0.25, 0.5 + gap)),
                  {Vec3(-1, -1.25, z), Vec3(1.5, -1.25, z), Vec3(-1, 1.5, z), Vec3(1.5, 1.5, z)}, Vec3::UnitZ(), gap);
  }
}

TEST(PolygonPoints, AnEdgeOnAFaceStandsOnItsEndsOrWhereTheFaceEnds) {
  const double half = std::sqrt(0.5);
  const Mat3 roof = turned(kPi / 4, Vec3::UnitX());
  for (const double gap : kGaps) {
    const double z = 0.25 + 0.5 * gap;
    expect_points(manifold_points(slab(), cube(), roof, Vec3(0.2, 0.1, 0.25 + half + gap)),
                  {Vec3(-0.3, 0.1, z), Vec3(0.7, 0.1, z)}, Vec3::UnitZ(), gap);
    expect_points(manifold_points(slab(), cube(), roof, Vec3(1.2, 0.1, 0.25 + half + gap)),
                  {Vec3(0.7, 0.1, z), Vec3(1.5, 0.1, z)}, Vec3::UnitZ(), gap);
  }
}

TEST(PolygonPoints, ACornerOnAFaceAndAnEdgeAcrossAnEdgeAreOnePlace) {
  const double half = std::sqrt(0.5);
  const Mat3 roof = turned(kPi / 4, Vec3::UnitX());
  const Mat3 keel = turned(0.9, Vec3::UnitZ()) * roof;
  for (const double gap : kGaps) {
    expect_points(manifold_points(slab(), cube(), on_its_corner(), Vec3(0.2, -0.3, 0.25 + std::sqrt(0.75) + gap)),
                  {Vec3(0.2, -0.3, 0.25 + 0.5 * gap)}, Vec3::UnitZ(), gap);
    const ManifoldPoints set =
        manifold_points(cube(), Pose{Vec3::Zero(), roof}, cube(), Pose{Vec3(0.1, 0.05, 2 * half + gap), keel});
    ASSERT_EQ(set.count, 1U);
    EXPECT_LT((roof * set.point[0].normal - Vec3::UnitZ()).norm(), 1e-6);
    EXPECT_NEAR(set.point[0].gap_m, gap, 1e-8);
    EXPECT_NEAR((roof * set.point[0].point_m).z(), half + 0.5 * gap, 1e-8);
  }
}

TEST(PolygonPoints, AGrooveHoldsFromBothSides) {
  static const ShapePtr groove = mesh_shape(groove_mesh(), 1);
  static const ShapePtr plinth = mesh_shape(box_mesh(Vec3(1, 1, 1)), 1);
  // Position of the bottom of the groove after the centre of mass was moved to the origin.
  const Vec3 bottom = groove->surface->vertices_m[4] + Vec3(0, 2, 0);
  const double edge_m = std::sqrt(0.5);
  for (const double gap : kGaps) {
    // The gap is measured along the slanted faces.
    const Vec3 offset = bottom + Vec3(0, 0.2, edge_m + gap * std::sqrt(2));
    const ManifoldPoints set = manifold_points(*groove, *plinth, turned(kPi / 4, Vec3::UnitY()), offset);
    ASSERT_GE(set.count, 6U) << gap;
    std::size_t left = 0;
    for (const ManifoldPoint& p : set.all()) {
      EXPECT_NEAR(p.gap_m, gap, 1e-7);
      EXPECT_NEAR(p.normal.z(), edge_m, 1e-6);
      if (p.normal.x() > 0) ++left;
    }
    EXPECT_GE(left, 2U);
    EXPECT_GE(set.count - left, 2U);
  }
}

TEST(PolygonPoints, ASharpKeelAtTheBottomOfAGrooveIsHeldFromBothSidesAboveAndBelowTheTouch) {
  static const ShapePtr groove = mesh_shape(groove_mesh(), 1);
  TriangleMesh wedge;
  wedge.vertices_m = {Vec3(0, -0.5, 0),   Vec3(0, 0.5, 0),    Vec3(-0.3, -0.5, 1),
                      Vec3(-0.3, 0.5, 1), Vec3(0.3, -0.5, 1), Vec3(0.3, 0.5, 1)};
  wedge.triangles = {{0, 4, 2}, {1, 3, 5}, {0, 1, 5}, {0, 5, 4}, {0, 2, 3}, {0, 3, 1}, {2, 4, 5}, {2, 5, 3}};
  static const ShapePtr keel = mesh_shape(wedge, 1);
  const Vec3 bottom = groove->surface->vertices_m[4] + Vec3(0, 2, 0);
  const Vec3 edge = keel->surface->vertices_m[0] + Vec3(0, 0.5, 0);
  for (const double gap : {1e-4, 1e-6, -1e-6, -1e-4}) {
    const ManifoldPoints set =
        manifold_points(*groove, *keel, Mat3::Identity(), bottom + Vec3(0, 0, gap * std::sqrt(2)) - edge);
    ASSERT_EQ(set.count, 4U) << gap;
    for (const ManifoldPoint& p : set.all()) {
      EXPECT_NEAR(p.gap_m, gap, 1e-8) << p.normal.transpose();
      EXPECT_NEAR(std::abs(p.point_m.y() - bottom.y()), 0.5, 1e-6);
    }
    EXPECT_EQ(std::ranges::count_if(set.all(), [](const ManifoldPoint& p) { return p.normal.x() > 0; }), 2);
  }
}

TEST(PolygonPoints, AMeshOnAPlaneStandsOnItsLowestCorners) {
  const ShapePtr floor = make_plane_shape(Vec3::UnitZ(), 0).value();
  static const ShapePtr round = mesh_shape(test::ball_mesh(0.5, 4), 0);
  for (const double gap : kGaps) {
    const double z = -0.5 - 0.5 * gap;
    expect_points(manifold_points(cube(), Pose{Vec3(3, 4, 0.5 + gap), Mat3::Identity()}, *floor, Pose{}),
                  {Vec3(-0.5, -0.5, z), Vec3(0.5, -0.5, z), Vec3(-0.5, 0.5, z), Vec3(0.5, 0.5, z)}, -Vec3::UnitZ(),
                  gap);
    const Mat3 roof = turned(kPi / 4, Vec3::UnitX());
    EXPECT_EQ(manifold_points(cube(), Pose{Vec3(0, 0, std::sqrt(0.5) + gap), roof}, *floor, Pose{}).count, 2U);
    EXPECT_EQ(manifold_points(cube(), Pose{Vec3(0, 0, std::sqrt(0.75) + gap), on_its_corner()}, *floor, Pose{}).count,
              1U);
    const ManifoldPoints set =
        manifold_points(*round, Pose{Vec3(0, 0, 0.5 + gap), turned(0.3, Vec3(1, 2, 3))}, *floor, Pose{});
    EXPECT_GE(set.count, 1U);
    EXPECT_NEAR(set.point[0].gap_m, gap, 3e-3);
    EXPECT_LT(set.point[0].point_m.cross(set.point[0].normal).norm(), 0.06);
  }
}

TEST(PolygonPoints, BallsOnAMeshRestOneByOne) {
  const ShapePtr dumbbell =
      make_spheres_shape(std::vector<Sphere>{{Vec3(-0.4, 0, 0), 0.2}, {Vec3(0.4, 0, 0), 0.2}}).value();
  static const ShapePtr groove = mesh_shape(groove_mesh(), 1);
  const ShapePtr ball = make_sphere_shape(0.4).value();
  const Vec3 bottom = groove->surface->vertices_m[4] + Vec3(0, 2, 0);
  for (const double gap : {1e-3, 0.0, -1e-3}) {
    expect_points(manifold_points(slab(), *dumbbell, Mat3::Identity(), Vec3(0.1, 0.2, 0.45 + gap)),
                  {Vec3(-0.3, 0.2, 0.25 + 0.5 * gap), Vec3(0.5, 0.2, 0.25 + 0.5 * gap)}, Vec3::UnitZ(), gap);
    expect_points(manifold_points(*dumbbell, slab(), Mat3::Identity(), Vec3(-0.1, -0.2, -0.45 - gap)),
                  {Vec3(-0.4, 0, -0.2 - 0.5 * gap), Vec3(0.4, 0, -0.2 - 0.5 * gap)}, -Vec3::UnitZ(), gap);
    const ManifoldPoints set =
        manifold_points(*groove, *ball, Mat3::Identity(), bottom + Vec3(0, 0.3, std::sqrt(2) * (0.4 + gap)));
    ASSERT_EQ(set.count, 2U);
    EXPECT_NEAR(set.point[0].normal.dot(set.point[1].normal), 0, 1e-6);
    for (const ManifoldPoint& p : set.all()) EXPECT_NEAR(p.gap_m, gap, 1e-7);
  }
}

TEST(PolygonPoints, AnOpenSurfaceCarriesOnTheSideWhereTheBodyIs) {
  TriangleMesh sheet;
  sheet.vertices_m = {Vec3(-2, -2, 0), Vec3(2, -2, 0), Vec3(2, 2, 0), Vec3(-2, 2, 0), Vec3(0.3, 0.2, 0)};
  sheet.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const ShapePtr ground = make_mesh_shape_with_tree(sheet, test::shared_tree(sheet, 1), 0.01).value();
  const double level = ground->surface->vertices_m[0].z();
  const Vec3 middle = ground->surface->vertices_m[0] + Vec3(2, 2, 0);
  for (const double side : {1.0, -1.0}) {
    for (const double gap : {1e-5, -1e-5, -1e-3}) {
      const ManifoldPoints set =
          manifold_points(*ground, cube(), Mat3::Identity(), middle + Vec3(0, 0, side * (0.5 + gap)));
      ASSERT_EQ(set.count, 4U) << side << " " << gap;
      for (const ManifoldPoint& p : set.all()) {
        EXPECT_NEAR(p.gap_m, gap, 1e-8);
        EXPECT_NEAR(p.normal.z(), side, 1e-9);
        EXPECT_NEAR(p.point_m.z(), level + side * 0.5 * gap, 1e-8);
      }
    }
  }
}

TEST(PolygonPoints, TheNearestPointIsAsFarAsASlowSearchSays) {
  static const ShapePtr torus = mesh_shape(test::torus_mesh(0.5, 0.2, 16, 8), 0);
  static const ShapePtr groove = mesh_shape(groove_mesh(), 1);
  const std::array<const Shape*, 4> shapes = {&cube(), &brick(), torus.get(), groove.get()};
  std::array<TrueSurface, 4> surfaces = {true_surface_of(*shapes[0]), true_surface_of(*shapes[1]),
                                         true_surface_of(*shapes[2]), true_surface_of(*shapes[3])};
  std::mt19937_64 random(11);
  int near = 0;
  for (int round = 0; round < 150; ++round) {
    const std::size_t i = random() % 4;
    const std::size_t k = random() % 4;
    const Mat3 turn = random_pose(random, 0).rotation;
    const Vec3 direction = random_pose(random, 0).rotation.col(0);
    // Moved together along a line until 2 mm are left.
    double at = shapes[i]->bounding_radius_m + shapes[k]->bounding_radius_m + 0.01;
    double distance = 1;
    for (int step = 0; step < 60 && distance > 2e-3; ++step) {
      distance = surface_distance_m(surfaces[i], Pose{}, surfaces[k], Pose{at * direction, turn});
      at -= 0.9 * std::max(0.0, distance - 1e-3);
    }
    distance = surface_distance_m(surfaces[i], Pose{}, surfaces[k], Pose{at * direction, turn});
    if (!(distance > 0) || distance > 4e-3) continue;
    ++near;
    const ManifoldPoints set = manifold_points(*shapes[i], *shapes[k], turn, at * direction);
    ASSERT_GE(set.count, 1U);
    double least = 1;
    for (const ManifoldPoint& p : set.all()) least = std::min(least, p.gap_m);
    EXPECT_NEAR(least, distance, 4e-6) << "round " << round;
  }
  EXPECT_GT(near, 60);
}

TEST(PolygonPoints, ADeepOverlapIsPushedOutOfTheFace) {
  const double smallest = cube().bounding_radius_m;
  for (const double share : {0.02, 0.05, 0.1}) {
    const double gap = -share * smallest;
    for (const Vec3& place : {Vec3(0.3, 0.2, 0), Vec3(1.3, -0.4, 0)}) {
      for (const double angle : {0.0, 0.35, kPi / 4}) {
        const ManifoldPoints set =
            manifold_points(slab(), cube(), turned(angle, Vec3::UnitZ()), place + Vec3(0, 0, 0.75 + gap));
        EXPECT_EQ(set.count, 4U) << share << " " << angle;
        double least = 0;
        for (const ManifoldPoint& p : set.all()) {
          EXPECT_GT(p.normal.z(), std::cos(10 * kPi / 180)) << share << " " << angle << " " << p.normal.transpose();
          least = std::min(least, p.gap_m);
        }
        EXPECT_NEAR(least, gap, 1e-6);
      }
    }
  }
}

TEST(PolygonPoints, WhereNothingCanBeToldTheImpactsAnswerIsTheOnePlace) {
  static const ShapePtr crumb = mesh_shape(box_mesh(Vec3(0.2, 0.2, 0.2)), 1);
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 16U);
  const PolygonAnswer answer = solve_by_polygons(cube(), *crumb, turned(0.3, Vec3(1, 2, 3)), Vec3(0.1, 0, 0.05), 0.02);
  ASSERT_TRUE(answer.contact.present);
  ASSERT_EQ(answer.level.manifold_points.count, 1U);
  const ManifoldPoint& manifold_point = answer.level.manifold_points.point[0];
  EXPECT_LT((manifold_point.normal - answer.contact.direction.normalized()).norm(), 1e-12);
  EXPECT_EQ(manifold_point.point_m, answer.contact.arm_m);
  EXPECT_EQ(manifold_point.gap_m, answer.contact.estimated_separation_m);
}

TEST(PolygonPoints, TurningBothBodiesTurnsTheirPlaces) {
  std::mt19937_64 random(12);
  for (int round = 0; round < 20; ++round) {
    const Pose moved = random_pose(random, 3);
    const double gap = uniform(random, -2e-3, 2e-3);
    const Pose above{Vec3(0.3, 0.2, 0.75 + gap), turned(0.2, Vec3::UnitZ())};
    const ManifoldPoints here = manifold_points(slab(), Pose{}, cube(), above);
    const ManifoldPoints there =
        manifold_points(slab(), moved, cube(),
                        Pose{moved.position_m + moved.rotation * above.position_m, moved.rotation * above.rotation});
    ASSERT_EQ(here.count, there.count);
    for (const ManifoldPoint& p : here.all()) {
      EXPECT_TRUE(std::ranges::any_of(there.all(), [&](const ManifoldPoint& q) {
        return (p.point_m - q.point_m).norm() < 1e-8 && (p.normal - q.normal).norm() < 1e-8 &&
               std::abs(p.gap_m - q.gap_m) < 1e-8;
      }));
    }
  }
}

TEST(PolygonPoints, PiecesOfAnySizeGiveTheSamePlaces) {
  static const ShapePtr torus = mesh_shape(test::torus_mesh(0.5, 0.2, 20, 10), 0);
  std::mt19937_64 random(13);
  int found = 0;
  for (int round = 0; round < 20; ++round) {
    const Mat3 turn = random_pose(random, 0).rotation;
    const Vec3 offset = random_vector(random, 0.6);
    const ManifoldPoints whole = solve_by_polygons(*torus, *torus, turn, offset, kMargin).level.manifold_points;
    const ManifoldPoints pieces = solve_by_polygons(*torus, *torus, turn, offset, kMargin, 10).level.manifold_points;
    ASSERT_EQ(whole.count, pieces.count);
    for (std::size_t i = 0; i < whole.count; ++i) {
      ++found;
      EXPECT_EQ(whole.point[i].point_m, pieces.point[i].point_m);
      EXPECT_EQ(whole.point[i].gap_m, pieces.point[i].gap_m);
      EXPECT_NEAR(whole.point[i].normal.norm(), 1, 1e-12);
    }
  }
  EXPECT_GT(found, 10);
}

TEST(PolygonPoints, APairThatDoesNotRestHasTheSameContactAndNoPlaces) {
  std::vector<FrontPool> pools;
  pools.emplace_back(1U << 16U);
  const PairFrame frame =
      make_pair_frame(slab(), Pose{}, cube(), Pose{Vec3(0.1, 0.2, 0.7501), Mat3::Identity()}, kMargin, 0);
  const PolygonAnswer resting = solve_by_polygons(frame, pools);
  const PolygonAnswer passing = solve_by_polygons(frame, pools, 1U << 30U, false);
  EXPECT_EQ(passing.level.manifold_points.count, 0U);
  EXPECT_EQ(resting.level.manifold_points.count, 4U);
  EXPECT_LT((passing.contact.direction - resting.contact.direction).norm(), 1e-12);
  EXPECT_NEAR(passing.contact.estimated_separation_m, resting.contact.estimated_separation_m, 1e-12);
}

}  // namespace
}  // namespace poise::collision
