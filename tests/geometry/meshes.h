// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "geometry/mesh/procedural.h"
#include "poise/mesh.h"
#include "poise/sphere_tree.h"

// Meshes and slow, simple computations for the tests of this folder. Nothing here uses the code under test.
namespace poise::test {

inline TriangleMesh box_mesh(const Vec3& size_m) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices_m.emplace_back(size_m.x() * ((i & 1) != 0 ? 0.5 : -0.5), size_m.y() * ((i & 2) != 0 ? 0.5 : -0.5),
                                 size_m.z() * ((i & 4) != 0 ? 0.5 : -0.5));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// An octahedron whose triangles are divided into four `splits` times, with all vertices projected onto the sphere.
inline TriangleMesh ball_mesh(double radius_m, int splits) {
  TriangleMesh mesh;
  mesh.vertices_m = {Vec3::UnitX(), -Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitZ()};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int split = 0; split < splits; ++split) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [place, added] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.vertices_m.size()));
      if (added) mesh.vertices_m.emplace_back((mesh.vertices_m[a] + mesh.vertices_m[b]).normalized());
      return place->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& t : mesh.triangles) {
      const std::uint32_t a = middle(t[0], t[1]);
      const std::uint32_t b = middle(t[1], t[2]);
      const std::uint32_t c = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vec3& v : mesh.vertices_m) v *= radius_m;
  return mesh;
}

inline TriangleMesh torus_mesh(double ring_m, double tube_m, int around, int tube) {
  TriangleMesh mesh;
  const auto index = [&](int a, int t) { return static_cast<std::uint32_t>(a % around * tube + t % tube); };
  for (int a = 0; a < around; ++a) {
    for (int t = 0; t < tube; ++t) {
      const double u = 2 * std::numbers::pi * a / around;
      const double v = 2 * std::numbers::pi * t / tube;
      const double out = ring_m + tube_m * std::cos(v);
      mesh.vertices_m.emplace_back(out * std::cos(u), out * std::sin(u), tube_m * std::sin(v));
      mesh.triangles.push_back({index(a, t), index(a + 1, t), index(a + 1, t + 1)});
      mesh.triangles.push_back({index(a, t), index(a + 1, t + 1), index(a, t + 1)});
    }
  }
  return mesh;
}

/// x -> turn * (factor * x) + shift.
inline TriangleMesh moved(TriangleMesh mesh, double factor, const Mat3& turn, const Vec3& shift) {
  for (Vec3& v : mesh.vertices_m) v = turn * (factor * v) + shift;
  return mesh;
}

/// Winding number by summing the solid angle of every triangle, with angles between edge planes (Girard) instead of the
/// arc tangent formula that the library uses.
inline double slow_winding(const TriangleMesh& mesh, const Vec3& point) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    std::array<Vec3, 3> d;
    for (std::size_t i = 0; i < 3; ++i) d[i] = (mesh.vertices_m[t[i]] - point).normalized();
    const double side = d[0].dot(d[1].cross(d[2]));
    if (side == 0) continue;
    double angles = -std::numbers::pi;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 left = d[i].cross(d[(i + 1) % 3]);
      const Vec3 right = d[i].cross(d[(i + 2) % 3]);
      angles += std::atan2(left.cross(right).norm(), left.dot(right));
    }
    sum += side > 0 ? angles : -angles;
  }
  return sum / (4 * std::numbers::pi);
}

/// Distance to a triangle by a descent over barycentric coordinates, with decreasing steps from the best point of a
/// coarse grid.
inline double slow_distance(const std::array<Vec3, 3>& t, const Vec3& point) {
  double best = 1e300;
  double bu = 0;
  double bv = 0;
  const auto consider = [&](double u, double v) {
    u = std::clamp(u, 0.0, 1.0);
    v = std::clamp(v, 0.0, 1.0 - u);
    const double d = (t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]) - point).norm();
    if (d < best - 1e-12) {
      best = d;
      bu = u;
      bv = v;
      return true;
    }
    return false;
  };
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; i + j <= 4; ++j) consider(i * 0.25, j * 0.25);
  }
  for (double step = 0.25; step > 1e-7;) {
    const double u = bu;
    const double v = bv;
    bool better = false;
    for (int turn = 0; turn < 16; ++turn) {
      const double angle = std::numbers::pi * turn / 8;
      better = consider(u + step * std::cos(angle), v + step * std::sin(angle)) || better;
    }
    if (!better) step *= 0.5;
  }
  return best;
}

inline double slow_distance(const TriangleMesh& mesh, const Vec3& point) {
  double best = 1e300;
  for (const auto& t : mesh.triangles) {
    best = std::min(best, slow_distance({mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]}, point));
  }
  return best;
}

inline double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11U) * 0x1.0p-53; }

inline Vec3 random_in_box(std::mt19937_64& random, const Vec3& low, const Vec3& high) {
  const Vec3 share(uniform(random), uniform(random), uniform(random));
  return low + share.cwiseProduct(high - low);
}

/// All vertices, the middles of all edges, and random points of triangles.
inline std::vector<Vec3> surface_points(const TriangleMesh& mesh, std::size_t random_count) {
  std::vector<Vec3> points = mesh.vertices_m;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i)
      points.emplace_back(0.5 * (mesh.vertices_m[t[i]] + mesh.vertices_m[t[(i + 1) % 3]]));
  }
  std::mt19937_64 random(11);
  for (std::size_t i = 0; i < random_count; ++i) {
    const auto& t = mesh.triangles[random() % mesh.triangles.size()];
    double u = uniform(random);
    double v = uniform(random);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    points.emplace_back((1 - u - v) * mesh.vertices_m[t[0]] + u * mesh.vertices_m[t[1]] + v * mesh.vertices_m[t[2]]);
  }
  return points;
}

inline std::vector<Vec3> inside_points(const TriangleMesh& mesh, std::size_t tries) {
  Vec3 low = mesh.vertices_m[0];
  Vec3 high = low;
  for (const Vec3& v : mesh.vertices_m) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  std::mt19937_64 random(12);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < tries; ++i) {
    const Vec3 point = random_in_box(random, low, high);
    if (slow_winding(mesh, point) > 0.5) points.push_back(point);
  }
  return points;
}

/// Number of levels from the root on for which a point has a chain of nodes that contain it; 0 if not even the root
/// contains it. A leaf represents itself at deeper levels.
inline std::size_t levels_covered(const SphereTree& tree, const Vec3& point) {
  const std::size_t levels = std::size_t{tree.depth()} + 1;
  std::vector<NodeIndex> holding;
  const auto holds = [&](NodeIndex node) {
    const Sphere s = tree.sphere(node);
    return (s.center_m - point).norm() <= s.radius_m;
  };
  if (holds(0)) holding.push_back(0);
  for (std::size_t level = 0; level < levels; ++level) {
    if (holding.empty()) return level;
    std::vector<NodeIndex> below;
    for (const NodeIndex node : holding) {
      if (tree.child_count[node] == 0) return levels;
      for (NodeIndex c = 0; c < tree.child_count[node]; ++c) {
        if (holds(tree.first_child[node] + c)) below.push_back(tree.first_child[node] + c);
      }
    }
    holding = std::move(below);
  }
  return levels;
}

/// Same arrays, bit for bit.
inline bool same_tree(const SphereTree& a, const SphereTree& b) {
  return a.x_m == b.x_m && a.y_m == b.y_m && a.z_m == b.z_m && a.radius_m == b.radius_m &&
         a.first_child == b.first_child && a.child_count == b.child_count && a.level_begin == b.level_begin &&
         a.protrusion_max_m == b.protrusion_max_m && a.protrusion_mean_m == b.protrusion_mean_m;
}

}  // namespace poise::test
