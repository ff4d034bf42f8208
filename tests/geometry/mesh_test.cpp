// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <rapidcheck/gtest.h>
#include <numbers>

#include "geometry/mesh/ear_clipping.h"
#include "meshes.h"

namespace poise {
namespace {

using test::box_mesh;

/// Every triangle with separate corners, as in STL.
TriangleMesh torn_apart(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const auto& t : mesh.triangles) {
    const auto base = static_cast<std::uint32_t>(soup.vertices_m.size());
    for (const std::uint32_t v : t) soup.vertices_m.push_back(mesh.vertices_m[v]);
    soup.triangles.push_back({base, base + 1, base + 2});
  }
  return soup;
}

TEST(Mesh, DiagonalIsThatOfTheBoundingBox) {
  EXPECT_DOUBLE_EQ(box_mesh({3, 4, 12}).diagonal_m(), 13);
  EXPECT_EQ(TriangleMesh{}.diagonal_m(), 0);
}

TEST(CleanMesh, WeldsATornMeshBackTogether) {
  TriangleMesh mesh = torn_apart(box_mesh(Vec3::Ones()));
  EXPECT_EQ(check_closed(mesh).open_edges, 36U);
  const MeshRepair repair = clean_mesh(mesh, 1e-6);
  EXPECT_EQ(repair.vertices_welded, 28U);
  EXPECT_EQ(repair.triangles_discarded, 0U);
  EXPECT_FALSE(repair.flipped);
  EXPECT_EQ(mesh.vertices_m.size(), 8U);
  EXPECT_TRUE(check_closed(mesh).closed());
}

TEST(CleanMesh, WeldsWithinTheToleranceAndNotBeyond) {
  for (const double gap : {0.5e-3, 2e-3}) {
    TriangleMesh mesh = torn_apart(box_mesh(Vec3::Ones()));
    const double diagonal = mesh.diagonal_m();
    mesh.vertices_m[0].x() += gap * diagonal;
    clean_mesh(mesh, 1e-3);
    EXPECT_EQ(check_closed(mesh).closed(), gap < 1e-3) << gap;
  }
}

TEST(CleanMesh, TheLowestIndexOfAWeldedGroupStays) {
  TriangleMesh mesh = torn_apart(box_mesh(Vec3::Ones()));
  const Vec3 first = mesh.vertices_m[0] + Vec3(1e-8, 0, 0);
  mesh.vertices_m[0] = first;
  clean_mesh(mesh, 1e-6);
  EXPECT_EQ(mesh.vertices_m[0], first);
}

TEST(CleanMesh, WithoutToleranceOnlyEqualVerticesAreOne) {
  TriangleMesh mesh = torn_apart(box_mesh(Vec3::Ones()));
  mesh.vertices_m[0].x() += 1e-15;
  EXPECT_EQ(clean_mesh(mesh, 0).vertices_welded, 27U);
}

TEST(CleanMesh, DropsTrianglesWithoutAreaAndRepeatedOnes) {
  TriangleMesh mesh = box_mesh(Vec3::Ones());
  mesh.triangles.push_back({3, 3, 4});
  mesh.triangles.push_back({mesh.triangles[2][1], mesh.triangles[2][2], mesh.triangles[2][0]});
  const MeshRepair repair = clean_mesh(mesh, 1e-6);
  EXPECT_EQ(repair.triangles_discarded, 2U);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  EXPECT_TRUE(check_closed(mesh).closed());
}

TEST(CleanMesh, KeepsANeedleWithoutWhichTheMeshWouldBeOpen) {
  // A vertex in the middle of an edge on one side, and a triangle without area that joins it to the whole edge.
  TriangleMesh mesh;
  mesh.vertices_m = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(), 0.5 * Vec3::UnitX()};
  mesh.triangles = {{0, 2, 4}, {4, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}, {0, 4, 1}};
  EXPECT_EQ(clean_mesh(mesh, 1e-6).triangles_discarded, 0U);
  EXPECT_TRUE(check_closed(mesh).closed());
}

TEST(CleanMesh, TurnsAClosedMeshOfNegativeVolumeInsideOut) {
  TriangleMesh mesh = box_mesh(Vec3::Ones());
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_TRUE(clean_mesh(mesh, 1e-6).flipped);
  EXPECT_NEAR(mesh_mass_properties(mesh).value().volume_m3, 1, 1e-15);
}

TEST(CleanMesh, LeavesOutUnusedVerticesAndTrianglesThatNameNone) {
  TriangleMesh mesh = box_mesh(Vec3::Ones());
  mesh.vertices_m.emplace_back(100, 100, 100);
  mesh.triangles.push_back({0, 1, 77});
  EXPECT_EQ(clean_mesh(mesh, 1e-9).triangles_discarded, 1U);
  EXPECT_EQ(mesh.vertices_m.size(), 8U);
}

RC_GTEST_PROP(CleanMesh, ASecondCleaningChangesNothing, (std::uint32_t seed)) {
  std::mt19937_64 random(seed);
  TriangleMesh mesh;
  const int vertices = 3 + static_cast<int>(random() % 30);
  for (int i = 0; i < vertices; ++i)
    mesh.vertices_m.push_back(test::random_in_box(random, -Vec3::Ones(), Vec3::Ones()));
  for (int i = 0; i < 40; ++i) {
    const auto pick = [&] { return static_cast<std::uint32_t>(random() % static_cast<std::uint64_t>(vertices)); };
    mesh.triangles.push_back({pick(), pick(), pick()});
  }
  clean_mesh(mesh, 1e-6);
  TriangleMesh again = mesh;
  const MeshRepair repair = clean_mesh(again, 1e-6);
  RC_ASSERT(repair.vertices_welded == 0U);
  RC_ASSERT(repair.triangles_discarded == 0U);
  RC_ASSERT(again.triangles == mesh.triangles);
}

TEST(CheckClosed, CountsOpenEdgesAndTurnedTriangles) {
  TriangleMesh mesh = box_mesh(Vec3::Ones());
  EXPECT_TRUE(check_closed(mesh).closed());
  std::swap(mesh.triangles[0][0], mesh.triangles[0][1]);
  EXPECT_EQ(check_closed(mesh).open_edges, 0U);
  EXPECT_EQ(check_closed(mesh).inconsistent_edges, 3U);
  mesh.triangles.erase(mesh.triangles.begin());
  EXPECT_EQ(check_closed(mesh).open_edges, 3U);
}

double area_of(const std::vector<Vec3>& vertices, const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  double area = 0;
  for (const auto& t : triangles)
    area += 0.5 * (vertices[t[1]] - vertices[t[0]]).cross(vertices[t[2]] - vertices[t[0]]).norm();
  return area;
}

TEST(Polygon, AConcaveOneIsCutWithoutLeavingIt) {
  // An arrow head in a slanted plane: the areas of the triangles must add up to its area.
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  std::vector<Vec3> vertices{{0, 0, 0}, {2, 1, 0}, {0, 2, 0}, {0.5, 1, 0}};
  for (Vec3& v : vertices) v = turn * v;
  for (std::uint32_t start = 0; start < 4; ++start) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    const std::vector<std::uint32_t> corners{start, (start + 1) % 4, (start + 2) % 4, (start + 3) % 4};
    std::uint64_t tests = 1000;
    EXPECT_TRUE(geometry::triangulate_polygon(vertices, corners, tests, triangles));
    EXPECT_EQ(triangles.size(), 2U);
    EXPECT_NEAR(area_of(vertices, triangles), 1.5, 1e-14);
  }
}

TEST(Polygon, OneThatCrossesItselfStillGivesTwoTrianglesLess) {
  const std::vector<Vec3> vertices{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 0.5, 0}};
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::uint64_t tests = 1000;
  EXPECT_TRUE(geometry::triangulate_polygon(vertices, std::vector<std::uint32_t>{0, 1, 2, 3, 4}, tests, triangles));
  EXPECT_EQ(triangles.size(), 3U);
  EXPECT_TRUE(geometry::triangulate_polygon(vertices, std::vector<std::uint32_t>{0, 1}, tests, triangles));
  EXPECT_EQ(triangles.size(), 3U);
}

TEST(Polygon, OneOf5000CornersThatCrossesItselfTakesAtMostThreeTimesTheSquare) {
  // A star drawn in one line: each corner is joined to the one nearly opposite.
  constexpr std::uint32_t kCorners = 5001;
  std::vector<Vec3> vertices;
  std::vector<std::uint32_t> star;
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    vertices.emplace_back(std::cos(angle), std::sin(angle), 0);
    star.push_back(i * (kCorners / 2) % kCorners);
  }
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::uint64_t tests = geometry::kMostPolygonTests;
  EXPECT_TRUE(geometry::triangulate_polygon(vertices, star, tests, triangles));
  EXPECT_EQ(triangles.size(), kCorners - 2);
  EXPECT_LE(geometry::kMostPolygonTests - tests, std::uint64_t{3} * kCorners * kCorners);
}

// What the limit of a file's comparisons is in corners (docs/reliability.md).
TEST(Polygon, AConvexOneTakesHalfTheSquareSoThatTheLimitIsAbout24000Corners) {
  const auto round_polygon = [](std::uint32_t corners, std::uint64_t& tests) {
    std::vector<Vec3> vertices;
    std::vector<std::uint32_t> in_order;
    for (std::uint32_t i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * i / corners;
      vertices.emplace_back(std::cos(angle), std::sin(angle), 0);
      in_order.push_back(i);
    }
    std::vector<std::array<std::uint32_t, 3>> triangles;
    return geometry::triangulate_polygon(vertices, in_order, tests, triangles);
  };
  constexpr std::uint32_t kCorners = 2400;
  std::uint64_t tests = geometry::kMostPolygonTests;
  EXPECT_TRUE(round_polygon(kCorners, tests));
  const double share = static_cast<double>(geometry::kMostPolygonTests - tests) / kCorners / kCorners;
  EXPECT_GT(share, 0.45);
  EXPECT_LT(share, 0.52) << "24,000^2 times this is the limit";
  tests = geometry::kMostPolygonTests;
  EXPECT_FALSE(round_polygon(24'500, tests));
}

TEST(Polygon, MoreComparisonsThanAllowedAreRefusedBeforeTheyAreDone) {
  const std::vector<Vec3> vertices{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::uint64_t tests = 100;
  EXPECT_FALSE(geometry::triangulate_polygon(vertices, std::vector<std::uint32_t>(20, 1), tests, triangles));
  EXPECT_TRUE(triangles.empty());
  EXPECT_EQ(tests, 100U);
}

}  // namespace
}  // namespace poise
