// SPDX-License-Identifier: MIT
#include "query/body_surface.h"

#include <gtest/gtest.h>

#include <numbers>

#include "geometry/meshes.h"
#include "query/brute_force.h"
#include "query/triangle_queries.h"

namespace poise::query {
namespace {

using test::Corners;
using test::kNone;

const std::filesystem::path kMeshes = std::filesystem::path(POISE_SOURCE_DIR) / "scenes/meshes";
const std::filesystem::path kOpenMeshes = "/usr/share/assimp/models";

BodySurface ball(double radius_m) { return BodySurface(make_sphere_shape(radius_m).value()); }
BodySurface box(const Vec3& size_m) { return BodySurface(test::mesh_shape(test::box_mesh(size_m))); }

/// Shipped closed meshes, and open meshes of other packages if installed, each with a diagonal of 1 m.
std::vector<ShapePtr> real_meshes() {
  std::vector<ShapePtr> shapes;
  for (const char* name : {"jack.obj", "torus.obj", "bowl.obj", "l.obj"})
    shapes.push_back(test::mesh_file(kMeshes / name));
  for (const char* name : {"OBJ/spider.obj", "OBJ/WusonOBJ.obj", "PLY/Wuson.ply"}) {
    if (std::filesystem::exists(kOpenMeshes / name)) shapes.push_back(test::mesh_file(kOpenMeshes / name, 1e-3));
  }
  return shapes;
}

TEST(RaysAtMeshes, AreThoseOfAllTrianglesOneByOne) {
  std::mt19937_64 random(1);
  for (const ShapePtr& shape : real_meshes()) {
    const BodySurface surface(shape);
    const std::vector<Corners> triangles = test::triangles_of(*shape);
    int hits = 0;
    for (int i = 0; i < 300; ++i) {
      const Vec3 origin = test::vector_within(random, 1.5);
      const Vec3 d = (test::vector_within(random, 0.3) - origin).normalized();
      const double expected = test::ray_distance(origin, d, triangles);
      const auto hit = surface.cast_ray(origin, d, kNone, true);
      ASSERT_EQ(hit.has_value(), expected < kNone);
      if (!hit) continue;
      ++hits;
      ASSERT_NEAR(hit->distance_m, expected, 1e-12);
      EXPECT_LT((hit->point_m - origin - expected * d).norm(), 1e-12);
      EXPECT_NEAR(hit->normal.norm(), 1, 1e-12);
      if (!surface.contains(origin)) {
        EXPECT_LE(hit->normal.dot(d), 1e-9);
      }
      // No hit if the ray ends before the surface.
      EXPECT_FALSE(surface.cast_ray(origin, d, expected * (1 - 1e-9), true));
    }
    EXPECT_GT(hits, 20);
  }
}

TEST(RaysAtMeshes, ThroughEdgesAndCornersOfAClosedMeshNeverSlipIn) {
  const BodySurface surface(test::mesh_shape(test::ball_mesh(1, 3)));
  std::mt19937_64 random(2);
  for (const ShapeSurface::Triangle& t : surface.shape()->surface->triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& v = surface.shape()->surface->vertices_m;
      const double share = test::uniform(random, 0, 1);
      for (const Vec3& aim :
           {v[t.vertex[k]], Vec3(v[t.vertex[k]] + share * (v[t.vertex[(k + 1) % 3]] - v[t.vertex[k]]))}) {
        const Vec3 origin = 5 * test::direction(random);
        if ((aim - origin).dot(aim) > -2) continue;  // near the rim a ray may miss
        const auto hit = surface.cast_ray(origin, (aim - origin).normalized(), kNone, false);
        ASSERT_TRUE(hit);
        EXPECT_NEAR(hit->distance_m, (aim - origin).norm(), 1e-9);
      }
    }
  }
}

TEST(RaysAtMeshes, OfAFarOriginLoseNothingButTheDigitsOfTheOrigin) {
  const BodySurface cube = box(Vec3::Constant(1));
  for (const double far : {1e3, 1e6, 1e9}) {
    const auto hit = cube.cast_ray({far, 0.1, 0.2}, -Vec3::UnitX(), kNone, false);
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance_m, far - 0.5, 4e-16 * far);
    EXPECT_EQ(hit->normal, Vec3(1, 0, 0));
  }
}

TEST(RaysFromInside, HitAtOnceOrWhereTheyLeave) {
  const Vec3 from(0.1, 0.2, -0.1);
  const Vec3 d = Vec3(1, 2, 3).normalized();
  const std::vector<Sphere> two = {{Vec3::Zero(), 1}, {Vec3(1, 0, 0), 1}};
  const BodySurface pair(make_spheres_shape(two).value());
  const BodySurface plane(make_plane_shape(Vec3::UnitZ(), 2).value());
  for (const BodySurface& solid : {box(Vec3::Constant(1)), ball(1)}) {
    const auto at_once = solid.cast_ray(from, d, kNone, false);
    ASSERT_TRUE(at_once);
    EXPECT_TRUE(at_once->at_start);
    EXPECT_EQ(at_once->distance_m, 0);
    EXPECT_EQ(at_once->point_m, from);
    EXPECT_EQ(at_once->normal, -d);
  }
  const auto out_of_box = box(Vec3::Constant(1)).cast_ray(from, Vec3::UnitX(), kNone, true);
  EXPECT_NEAR(out_of_box.value().distance_m, 0.4, 1e-15);
  EXPECT_EQ(out_of_box.value().normal, Vec3(1, 0, 0));
  EXPECT_NEAR(ball(2).cast_ray({1, 0, 0}, Vec3::UnitX(), kNone, true).value().distance_m, 1, 1e-15);
  // From one ball through the other; the centre of mass is midway between them.
  EXPECT_NEAR(pair.cast_ray({-1, 0, 0}, Vec3::UnitX(), kNone, true).value().distance_m, 2.5, 1e-12);
  EXPECT_FALSE(pair.cast_ray({-1, 0, 0}, Vec3::UnitX(), 2.4, true));
  EXPECT_NEAR(plane.cast_ray({0, 0, -1}, Vec3::UnitZ(), kNone, true).value().distance_m, 3, 1e-15);
  EXPECT_FALSE(plane.cast_ray({0, 0, -1}, -Vec3::UnitZ(), kNone, true));
}

TEST(RaysAtBallsAndPlanes, AreClosedForms) {
  const auto hit = ball(0.5).cast_ray({-3, 0.3, 0}, Vec3::UnitX(), kNone, false);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance_m, 3 - 0.4, 1e-15);
  EXPECT_LT((hit->normal - Vec3(-0.8, 0.6, 0)).norm(), 1e-15);
  EXPECT_FALSE(ball(0.5).cast_ray({-3, 0.6, 0}, Vec3::UnitX(), kNone, false));
  EXPECT_FALSE(ball(0.5).cast_ray({3, 0, 0}, Vec3::UnitX(), kNone, false));
  const BodySurface plane(make_plane_shape({0, 3, 4}, 1).value());
  const Vec3 normal(0, 0.6, 0.8);
  const Vec3 d = Vec3(1, -1, -2).normalized();
  const auto on_plane = plane.cast_ray(6 * normal, d, kNone, false);
  EXPECT_NEAR(on_plane.value().distance_m, -5 / d.dot(normal), 1e-14);
  EXPECT_NEAR(on_plane.value().point_m.dot(normal), 1, 1e-14);
  EXPECT_FALSE(plane.cast_ray(6 * normal, Vec3::UnitX(), kNone, false));
}

TEST(MovingSpheresAtMeshes, StopWhereMarchingDoes) {
  std::mt19937_64 random(3);
  for (const ShapePtr& shape : real_meshes()) {
    const BodySurface surface(shape);
    const std::vector<Corners> triangles = test::triangles_of(*shape);
    if (triangles.size() > 20000) continue;
    int hits = 0;
    for (int i = 0; i < 60; ++i) {
      const double radius = i % 3 == 0 ? 0.01 : test::uniform(random, 0.02, 0.4);
      const Vec3 center = 1.2 * test::direction(random);
      const Vec3 d = (test::vector_within(random, 0.4) - center).normalized();
      const double expected = test::march(center, radius, d, 3, triangles);
      const auto hit = surface.cast_sphere(center, radius, d, 3);
      if (expected == kNone) {
        // Marching cannot distinguish a near miss from a contact.
        if (hit) {
          EXPECT_NEAR(test::distance_to(center + hit->distance_m * d, triangles), radius, 1e-8);
        }
        continue;
      }
      ASSERT_TRUE(hit) << expected;
      ++hits;
      if (hit->at_start) {
        EXPECT_LT(expected, 1e-9);
        continue;
      }
      // At a grazing contact the last 1e-10 m of the march are a long distance along the ray; the ball must touch, and
      // not before.
      const Vec3 there = center + hit->distance_m * d;
      EXPECT_NEAR(test::distance_to(there, triangles), radius, 1e-9);
      EXPECT_NEAR((there - hit->point_m).norm(), radius, 1e-9);
      EXPECT_GE(hit->distance_m, expected - 1e-9);
      EXPECT_NEAR(hit->normal.dot(there - hit->point_m), radius, 1e-9);
      EXPECT_LE(hit->normal.dot(d), 1e-6);
    }
    EXPECT_GT(hits, 10);
  }
}

TEST(MovingSpheres, HitFacesEdgesAndCornersOfABoxWhereTheyMust) {
  const BodySurface cube = box(Vec3::Constant(2));
  const Vec3 down = -Vec3::UnitZ();
  EXPECT_NEAR(cube.cast_sphere({0.2, 0.3, 5}, 0.5, down, kNone).value().distance_m, 3.5, 1e-14);
  // Beside an edge by 0.3, with a radius of 0.5: the centre is 0.4 above the edge.
  EXPECT_NEAR(cube.cast_sphere({1.3, 0.3, 5}, 0.5, down, kNone).value().distance_m, 3.6, 1e-14);
  // Beside a corner by (0.3, 0.24): the centre is 0.32 above it.
  const double above = std::sqrt(0.25 - 0.09 - 0.0576);
  const auto corner = cube.cast_sphere({1.3, 1.24, 5}, 0.5, down, kNone);
  EXPECT_NEAR(corner.value().distance_m, 4 - above, 1e-14);
  EXPECT_LT((corner.value().point_m - Vec3(1, 1, 1)).norm(), 1e-14);
  EXPECT_LT((corner.value().normal - Vec3(0.6, 0.48, 2 * above)).norm(), 1e-13);
  EXPECT_FALSE(cube.cast_sphere({1.51, 0.3, 5}, 0.5, down, kNone));
  EXPECT_FALSE(cube.cast_sphere({0.2, 0.3, 5}, 0.5, down, 3.4));
}

TEST(MovingSpheres, ThatOverlapAtTheStartSayTheNearestPoint) {
  const BodySurface cube = box(Vec3::Constant(2));
  for (const Vec3& center : {Vec3(0.1, 0, 0.8), Vec3(0.1, 0, 1.2)}) {
    const auto hit = cube.cast_sphere(center, 0.3, Vec3::UnitX(), kNone);
    ASSERT_TRUE(hit);
    EXPECT_TRUE(hit->at_start);
    EXPECT_EQ(hit->distance_m, 0);
    EXPECT_LT((hit->point_m - Vec3(0.1, 0, 1)).norm(), 1e-15);
    EXPECT_LT((hit->normal - Vec3::UnitZ()).norm(), 1e-15);
  }
  // Deep inside, and smaller than the distance to the surface.
  EXPECT_TRUE(cube.cast_sphere(Vec3::Zero(), 0.1, Vec3::UnitX(), kNone).value().at_start);
}

TEST(MovingSpheres, OfRadiusZeroAreRays) {
  std::mt19937_64 random(4);
  const BodySurface surface(test::mesh_file(kMeshes / "torus.obj"));
  for (int i = 0; i < 200; ++i) {
    const Vec3 origin = 2 * test::direction(random);
    const Vec3 d = (test::vector_within(random, 0.3) - origin).normalized();
    const auto ray = surface.cast_ray(origin, d, kNone, false);
    const auto sphere = surface.cast_sphere(origin, 0, d, kNone);
    ASSERT_EQ(ray.has_value(), sphere.has_value());
    if (ray) {
      EXPECT_EQ(ray->distance_m, sphere->distance_m);
    }
  }
}

TEST(MovingSpheresAtBallsAndPlanes, AreClosedForms) {
  EXPECT_NEAR(ball(0.5).cast_sphere({-3, 0.9, 0}, 1, Vec3::UnitX(), kNone).value().distance_m, 3 - 1.2, 1e-14);
  const BodySurface plane(make_plane_shape(Vec3::UnitZ(), 1).value());
  const auto hit = plane.cast_sphere({1, 2, 5}, 0.25, Vec3(0, 3, -4) / 5, kNone);
  EXPECT_NEAR(hit.value().distance_m, 3.75 / 0.8, 1e-14);
  EXPECT_NEAR(hit.value().point_m.z(), 1, 1e-14);
  EXPECT_TRUE(plane.cast_sphere({1, 2, 1.2}, 0.25, Vec3::UnitZ(), kNone).value().at_start);
}

TEST(Overlaps, OfBallsWithMeshesAreThoseOfAllTriangles) {
  std::mt19937_64 random(5);
  for (const ShapePtr& shape : real_meshes()) {
    const BodySurface surface(shape);
    const std::vector<Corners> triangles = test::triangles_of(*shape);
    for (int i = 0; i < 200; ++i) {
      const Vec3 center = test::vector_within(random, 0.7);
      const double radius = test::uniform(random, 0, 0.3);
      const double distance = test::distance_to(center, triangles);
      const bool expected = distance <= radius || surface.contains(center);
      EXPECT_EQ(surface.overlaps_ball(center, radius), expected) << distance << " " << radius;
    }
  }
}

TEST(Overlaps, OfBoxesWithMeshesAreThoseOfClippedTriangles) {
  std::mt19937_64 random(6);
  for (const ShapePtr& shape : real_meshes()) {
    const BodySurface surface(shape);
    const std::vector<Corners> triangles = test::triangles_of(*shape);
    int met = 0;
    for (int i = 0; i < 200; ++i) {
      const Mat3 rotation = test::turn(random).toRotationMatrix();
      const Vec3 offset = test::vector_within(random, 0.6);
      const Vec3 half = test::vector_within(random, 0.25).cwiseAbs();
      const bool inside = surface.contains(rotation.transpose() * -offset);
      const bool expected = test::clipped_by_box(triangles, rotation, offset, half) || inside;
      EXPECT_EQ(surface.overlaps_box(rotation, offset, half), expected);
      met += expected ? 1 : 0;
    }
    EXPECT_GT(met, 5);
    EXPECT_LT(met, 195);
  }
}

TEST(Overlaps, OfBoxesWithBallsAndPlanesAreClosedForms) {
  const Vec3 half(1, 2, 3);
  const Mat3 none = Mat3::Identity();
  // 0.5 beyond a corner along its diagonal.
  const Vec3 beyond = half + 0.5 * Vec3::Constant(1 / std::sqrt(3.0));
  EXPECT_TRUE(ball(0.501).overlaps_box(none, beyond, half));
  EXPECT_FALSE(ball(0.499).overlaps_box(none, beyond, half));
  EXPECT_TRUE(ball(0.1).overlaps_box(none, Vec3::Zero(), half));
  const BodySurface plane(make_plane_shape(Vec3::UnitZ(), 0).value());
  const Mat3 on_edge = Eigen::AngleAxisd(std::numbers::pi / 4, Vec3::UnitX()).toRotationMatrix();
  const Vec3 cube = Vec3::Constant(1);
  EXPECT_TRUE(plane.overlaps_box(on_edge, on_edge * Vec3(0, 0, -1.41), cube));
  EXPECT_FALSE(plane.overlaps_box(on_edge, on_edge * Vec3(0, 0, -1.42), cube));
}

TEST(ClosestPoints, OfMeshesAreThoseOfAllTriangles) {
  std::mt19937_64 random(7);
  for (const ShapePtr& shape : real_meshes()) {
    const BodySurface surface(shape);
    const std::vector<Corners> triangles = test::triangles_of(*shape);
    for (int i = 0; i < 200; ++i) {
      const Vec3 p = test::vector_within(random, 0.7);
      const double expected = test::distance_to(p, triangles);
      const auto found = surface.closest(p, kNone);
      ASSERT_TRUE(found);
      EXPECT_NEAR(std::abs(found->distance_m), expected, 1e-12);
      EXPECT_EQ(found->distance_m < 0, surface.contains(p));
      EXPECT_NEAR((found->point_m - p).norm(), expected, 1e-12);
      EXPECT_LT((found->point_m + found->distance_m * found->normal - p).norm(), 1e-9);
      EXPECT_FALSE(surface.closest(p, expected * (1 - 1e-9)));
      EXPECT_TRUE(surface.closest(p, expected * (1 + 1e-9)));
    }
  }
}

TEST(ClosestPoints, OfBallsAndPlanesAreClosedForms) {
  const auto outside = ball(0.5).closest({0, 2, 0}, kNone);
  EXPECT_NEAR(outside.value().distance_m, 1.5, 1e-15);
  EXPECT_LT((outside.value().point_m - Vec3(0, 0.5, 0)).norm(), 1e-15);
  EXPECT_NEAR(ball(0.5).closest({0, 0.2, 0}, kNone).value().distance_m, -0.3, 1e-15);
  EXPECT_TRUE(ball(0.5).closest(Vec3::Zero(), kNone).value().normal.isUnitary());
  const BodySurface plane(make_plane_shape(Vec3::UnitX(), 1).value());
  EXPECT_EQ(plane.closest({-2, 3, 4}, kNone).value().distance_m, -3);
  EXPECT_EQ(plane.closest({-2, 3, 4}, kNone).value().point_m, Vec3(1, 3, 4));
  EXPECT_FALSE(plane.closest({-2, 3, 4}, 2.9));
}

TEST(Triangles, WithoutAreaStopASphereAsTheirEdgesDo) {
  const Corners needle = {Vec3(-1, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 0, 0)};
  EXPECT_NEAR(sphere_to_triangle_m({0, 0.3, 2}, 0.5, -Vec3::UnitZ(), needle), 1.6, 1e-15);
  EXPECT_EQ(sphere_to_triangle_m({0, 0.6, 2}, 0.5, -Vec3::UnitZ(), needle), kMiss);
  const Corners point = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  EXPECT_NEAR(sphere_to_triangle_m({0, 0.3, 2}, 0.5, -Vec3::UnitZ(), point), 1.6, 1e-15);
}

}  // namespace
}  // namespace poise::query
