// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <map>
#include <utility>

#include "oracle/oracle_mesh.h"

namespace poise::oracle {

/// A box about the origin.
inline TriangleMesh box_mesh(double x_m, double y_m, double z_m) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices_m.emplace_back((i & 1) != 0 ? 0.5 * x_m : -0.5 * x_m, (i & 2) != 0 ? 0.5 * y_m : -0.5 * y_m,
                                 (i & 4) != 0 ? 0.5 * z_m : -0.5 * z_m);
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A ball of radius 1 made from an octahedron whose triangles are divided into four `rounds` times.
inline TriangleMesh ball_mesh(int rounds) {
  TriangleMesh mesh;
  mesh.vertices_m = {Vec3::UnitX(), -Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitZ()};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int round = 0; round < rounds; ++round) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t i, std::uint32_t k) {
      const auto [at, fresh] = middles.try_emplace({std::min(i, k), std::max(i, k)}, mesh.vertices_m.size());
      if (fresh) mesh.vertices_m.push_back(Vec3(mesh.vertices_m[i] + mesh.vertices_m[k]).normalized());
      return at->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [i, j, k] : mesh.triangles) {
      const std::uint32_t ij = middle(i, j);
      const std::uint32_t jk = middle(j, k);
      const std::uint32_t ki = middle(k, i);
      finer.insert(finer.end(), {{i, ij, ki}, {ij, j, jk}, {ki, jk, k}, {ij, jk, ki}});
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

}  // namespace poise::oracle
