// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>
#include <vector>

#include "geometry/primitives/triangle_distance.h"
#include "geometry/shape/shape_surface.h"
#include "poise/assets/mesh_file.h"
#include "poise/mesh.h"
#include "poise/shape.h"

// Slow, simple computations on meshes, triangle by triangle. Nothing here uses the code under test.
namespace poise::test {

inline double uniform(std::mt19937_64& random, double least, double most) {
  return least + (most - least) * static_cast<double>(random() >> 11U) * 0x1.0p-53;
}
inline Vec3 vector_within(std::mt19937_64& random, double most) {
  const double x = uniform(random, -most, most);
  const double y = uniform(random, -most, most);
  return {x, y, uniform(random, -most, most)};
}
inline Vec3 direction(std::mt19937_64& random) {
  for (;;) {
    const Vec3 v = vector_within(random, 1);
    if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
  }
}
inline Quat turn(std::mt19937_64& random) {
  const Vec3 v = vector_within(random, 1);
  return Quat(uniform(random, -1, 1), v.x(), v.y(), v.z()).normalized();
}

using Corners = std::array<Vec3, 3>;

inline std::vector<Corners> triangles_of(const Shape& shape) {
  std::vector<Corners> triangles;
  for (const ShapeSurface::Triangle& t : shape.surface->triangles) {
    const auto& v = shape.surface->vertices_m;
    triangles.push_back({v[t.vertex[0]], v[t.vertex[1]], v[t.vertex[2]]});
  }
  return triangles;
}

inline constexpr double kNone = std::numeric_limits<double>::infinity();

/// By Cramer's rule (Möller and Trumbore 1997).
inline double ray_distance(const Vec3& origin, const Vec3& d, const std::vector<Corners>& triangles) {
  double least = kNone;
  for (const Corners& t : triangles) {
    const Vec3 e1 = t[1] - t[0];
    const Vec3 e2 = t[2] - t[0];
    const Vec3 p = d.cross(e2);
    const double det = e1.dot(p);
    if (det == 0) continue;
    const Vec3 s = origin - t[0];
    const double u = s.dot(p) / det;
    const Vec3 q = s.cross(e1);
    const double v = d.dot(q) / det;
    const double at = e2.dot(q) / det;
    if (u >= 0 && v >= 0 && u + v <= 1 && at >= 0) least = std::min(least, at);
  }
  return least;
}

inline double distance_to(const Vec3& p, const std::vector<Corners>& triangles) {
  double least = kNone;
  for (const Corners& t : triangles) least = std::min(least, (geometry::closest_on_triangle(p, t) - p).norm());
  return least;
}

/// By marching: the distance to the surface shrinks at most as fast as the ball moves.
inline double march(Vec3 center, double radius, const Vec3& d, double limit, const std::vector<Corners>& triangles) {
  double moved = 0;
  for (int i = 0; i < 100000 && moved <= limit; ++i) {
    const double free = distance_to(center + moved * d, triangles) - radius;
    if (free < 1e-10) return moved;
    moved += free;
  }
  return kNone;
}

/// Clips each triangle by the six sides of the box |x| <= half.
inline bool clipped_by_box(const std::vector<Corners>& triangles, const Mat3& rotation, const Vec3& offset,
                           const Vec3& half) {
  for (const Corners& t : triangles) {
    std::vector<Vec3> polygon;
    for (const Vec3& p : t) polygon.emplace_back(rotation * p + offset);
    for (int side = 0; side < 6 && !polygon.empty(); ++side) {
      const Eigen::Index axis = side / 2;
      const double sign = side % 2 == 0 ? 1.0 : -1.0;
      std::vector<Vec3> kept;
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec3& p = polygon[i];
        const Vec3& q = polygon[(i + 1) % polygon.size()];
        const double hp = sign * p[axis] - half[axis];
        const double hq = sign * q[axis] - half[axis];
        if (hp <= 0) kept.push_back(p);
        if ((hp < 0 && hq > 0) || (hp > 0 && hq < 0)) kept.emplace_back(p + hp / (hp - hq) * (q - p));
      }
      polygon = std::move(kept);
    }
    if (!polygon.empty()) return true;
  }
  return false;
}

/// A shape with the mesh's true surface and a tree of one sphere, which queries do not use.
inline ShapePtr mesh_shape(const TriangleMesh& mesh, double shell_thickness_m = 0) {
  geometry::Bounds box;
  for (const Vec3& v : mesh.vertices_m) box.add(v);
  const Sphere all{box.center(), 0.51 * (box.high - box.low).norm()};
  const SphereTree tree = tree_of_spheres(std::span(&all, 1)).value();
  Result<ShapePtr> shape = make_mesh_shape_with_tree(mesh, tree, shell_thickness_m);
  EXPECT_TRUE(shape.ok()) << (shape.ok() ? "" : shape.error().message);
  return shape.value();
}

inline ShapePtr mesh_file(const std::filesystem::path& file, double shell_thickness_m = 0) {
  MeshReadOptions options;
  Result<TriangleMesh> mesh = read_mesh(file, options);
  EXPECT_TRUE(mesh.ok()) << (mesh.ok() ? "" : mesh.error().message);
  const double diagonal_m = mesh.value().diagonal_m();
  for (Vec3& v : mesh.value().vertices_m) v /= diagonal_m;
  return mesh_shape(mesh.value(), shell_thickness_m);
}

}  // namespace poise::test
