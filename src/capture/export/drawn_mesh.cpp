// SPDX-License-Identifier: MIT
#include "capture/export/drawn_mesh.h"

#include <cmath>
#include <map>
#include <utility>

#include "poise/types.h"

namespace poise::capture {
namespace {

// 320 triangles for a ball alone, 80 for each ball of a union. Chosen.
constexpr int kSplitsOfBall = 2;
constexpr int kSplitsOfUnion = 1;

/// A unit ball from an icosahedron, each triangle split into four so many times.
struct Geodesic {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

Geodesic geodesic(int splits) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  Geodesic ball;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-g, g}) {
      for (const Vec3& vertex : {Vec3(0, a, b), Vec3(a, b, 0), Vec3(b, 0, a)})
        ball.vertices.push_back(vertex.normalized());
    }
  }
  const auto near = [&](std::uint32_t i, std::uint32_t k) {
    // Edges of an icosahedron, and no other distances of its vertices, are shorter than its radius times 1.1.
    return (ball.vertices[i] - ball.vertices[k]).norm() < 1.1;
  };
  for (std::uint32_t i = 0; i < 12; ++i) {
    for (std::uint32_t j = i + 1; j < 12; ++j) {
      for (std::uint32_t k = j + 1; k < 12; ++k) {
        if (!near(i, j) || !near(j, k) || !near(i, k)) continue;
        const bool outward = ball.vertices[i].dot(ball.vertices[j].cross(ball.vertices[k])) > 0;
        ball.triangles.push_back(outward ? std::array{i, j, k} : std::array{i, k, j});
      }
    }
  }
  for (int split = 0; split < splits; ++split) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), ball.vertices.size());
      if (is_new) ball.vertices.push_back((ball.vertices[a] + ball.vertices[b]).normalized());
      return found->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : ball.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const std::array<std::uint32_t, 3>& triangle :
           {std::array{a, ab, ca}, std::array{ab, b, bc}, std::array{ca, bc, c}, std::array{ab, bc, ca}})
        finer.push_back(triangle);
    }
    ball.triangles = std::move(finer);
  }
  return ball;
}

std::array<float, 3> corner_of(const Vec3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

DrawnMesh square(const CapturedShape& plane, double reach_m) {
  const Vec3 normal(plane.normal[0], plane.normal[1], plane.normal[2]);
  const Vec3 across = normal.unitOrthogonal();
  const Vec3 along = normal.cross(across);
  DrawnMesh mesh;
  for (const auto& [a, b] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
    mesh.vertices_m.push_back(corner_of(normal * plane.offset_m + reach_m * (a * across + b * along)));
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

}  // namespace

DrawnMesh drawn_mesh(const CapturedShape& shape, double reach_m) {
  if (shape.plane) return square(shape, reach_m);
  DrawnMesh mesh;
  if (!shape.corners.empty()) {
    for (std::size_t i = 0; i + 2 < shape.vertices_m.size(); i += 3)
      mesh.vertices_m.push_back({shape.vertices_m[i], shape.vertices_m[i + 1], shape.vertices_m[i + 2]});
    for (std::size_t i = 0; i + 2 < shape.corners.size(); i += 3)
      mesh.triangles.push_back({shape.corners[i], shape.corners[i + 1], shape.corners[i + 2]});
    return mesh;
  }
  if (shape.levels.empty()) return mesh;
  const std::vector<CapturedSphere>& spheres = shape.levels.back();
  const Geodesic ball = geodesic(spheres.size() == 1 ? kSplitsOfBall : kSplitsOfUnion);
  for (const CapturedSphere& sphere : spheres) {
    const Vec3 center(static_cast<double>(sphere.x_m), static_cast<double>(sphere.y_m),
                      static_cast<double>(sphere.z_m));
    const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
    for (const Vec3& vertex : ball.vertices)
      mesh.vertices_m.push_back(corner_of(center + static_cast<double>(sphere.radius_m) * vertex));
    for (const auto& [a, b, c] : ball.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
  }
  return mesh;
}

}  // namespace poise::capture
