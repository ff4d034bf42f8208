// SPDX-License-Identifier: MIT
#include "poise/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "geometry/mesh/mesh_edges.h"
#include "geometry/mesh/mesh_orient.h"
#include "geometry/primitives/bounds.h"

namespace poise {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

struct Cell {
  std::int64_t x, y, z;
  friend bool operator==(const Cell&, const Cell&) = default;
};

struct CellHash {
  std::size_t operator()(const Cell& c) const {
    // Three odd constants derived from the golden ratio spread neighbouring cells; they affect only speed.
    return static_cast<std::size_t>(static_cast<std::uint64_t>(c.x) * 0x9e3779b97f4a7c15ULL ^
                                    static_cast<std::uint64_t>(c.y) * 0xc2b2ae3d27d4eb4fULL ^
                                    static_cast<std::uint64_t>(c.z) * 0x165667b19e3779f9ULL);
  }
};

/// For each vertex the lowest-numbered retained vertex within the tolerance, else itself.
std::vector<std::uint32_t> weld_targets(const std::vector<Vec3>& vertices_m, double tolerance_m, double diagonal_m) {
  const double cell_m = diagonal_m > 0 ? std::max(tolerance_m, 1e-9 * diagonal_m) : 1.0;
  Vec3 low = vertices_m.empty() ? Vec3(Vec3::Zero()) : vertices_m[0];
  for (const Vec3& v : vertices_m) low = low.cwiseMin(v);
  std::unordered_map<Cell, std::vector<std::uint32_t>, CellHash> kept;
  kept.reserve(vertices_m.size());
  std::vector<std::uint32_t> target(vertices_m.size());
  for (std::uint32_t i = 0; i < vertices_m.size(); ++i) {
    const Vec3 place = ((vertices_m[i] - low) / cell_m).array().floor();
    const Cell cell{static_cast<std::int64_t>(place.x()), static_cast<std::int64_t>(place.y()),
                    static_cast<std::int64_t>(place.z())};
    std::uint32_t best = i;
    for (int neighbour = 0; neighbour < 27; ++neighbour) {
      const auto found =
          kept.find({cell.x + neighbour % 3 - 1, cell.y + neighbour / 3 % 3 - 1, cell.z + neighbour / 9 - 1});
      if (found == kept.end()) continue;
      for (const std::uint32_t candidate : found->second) {
        if (candidate < best && (vertices_m[candidate] - vertices_m[i]).norm() <= tolerance_m) best = candidate;
      }
    }
    target[i] = best;
    if (best == i) kept[cell].push_back(i);
  }
  return target;
}

/// The triangle rotated to start at its lowest vertex, so that repeats compare equal and reversed triangles do not.
Triangle rotated_to_lowest(const Triangle& t) {
  if (t[0] < t[1] && t[0] < t[2]) return t;
  if (t[1] < t[0] && t[1] < t[2]) return {t[1], t[2], t[0]};
  return {t[2], t[0], t[1]};
}

/// Removes triangles that name a vertex twice, and later repeats of the same triangle. Returns their number.
std::size_t drop_triangles(std::vector<Triangle>& triangles) {
  const std::size_t before = triangles.size();
  std::erase_if(triangles, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  std::vector<std::uint32_t> order(triangles.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&](std::uint32_t i) { return rotated_to_lowest(triangles[i]); };
  std::ranges::stable_sort(order, {}, key);
  std::vector<bool> repeated(triangles.size(), false);
  for (std::size_t i = 1; i < order.size(); ++i) repeated[order[i]] = key(order[i]) == key(order[i - 1]);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (!repeated[i]) triangles[kept++] = triangles[i];
  }
  triangles.resize(kept);
  return before - kept;
}

/// Removes vertices that no triangle names; the order of the others stays.
void compact_vertices(TriangleMesh& mesh) {
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> place(mesh.vertices_m.size(), kUnused);
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) place[v] = 0;
  }
  std::uint32_t next = 0;
  for (std::size_t v = 0; v < place.size(); ++v) {
    if (place[v] == kUnused) continue;
    mesh.vertices_m[next] = mesh.vertices_m[v];
    place[v] = next++;
  }
  mesh.vertices_m.resize(next);
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = place[v];
  }
}

}  // namespace

double TriangleMesh::diagonal_m() const {
  const geometry::Bounds bounds = geometry::bounds_of(vertices_m);
  return vertices_m.empty() ? 0.0 : (bounds.high - bounds.low).norm();
}

MeshRepair clean_mesh(TriangleMesh& mesh, double weld_relative) {
  MeshRepair repair;
  // An index that names no vertex cannot come from read_mesh; such a triangle is removed.
  const std::size_t all = mesh.triangles.size();
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    return std::ranges::any_of(t, [&](std::uint32_t v) { return v >= mesh.vertices_m.size(); });
  });
  repair.triangles_discarded = all - mesh.triangles.size();
  const double diagonal_m = mesh.diagonal_m();
  const std::vector<std::uint32_t> target =
      weld_targets(mesh.vertices_m, std::max(0.0, weld_relative) * diagonal_m, diagonal_m);
  for (std::uint32_t v = 0; v < target.size(); ++v) repair.vertices_welded += target[v] != v ? 1U : 0U;
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = target[v];
  }
  repair.triangles_discarded += drop_triangles(mesh.triangles);
  compact_vertices(mesh);
  const geometry::Orientation orientation = geometry::orient_triangles(mesh);
  repair.triangles_turned = orientation.triangles_turned;
  repair.pieces_turned = orientation.pieces_turned;
  repair.flipped = orientation.all_turned;
  return repair;
}

ClosedCheck check_closed(const TriangleMesh& mesh) {
  const std::vector<geometry::EdgeUse> uses = geometry::edge_uses(mesh.triangles);
  ClosedCheck check;
  geometry::for_each_edge(uses, [&check](std::span<const geometry::EdgeUse> edge) {
    if (edge.size() == 1) {
      ++check.open_edges;
    } else if (geometry::edge_balance(edge) != 0) {
      ++check.inconsistent_edges;
    }
    check.crowded_edges += edge.size() > 2 ? 1U : 0U;
  });
  return check;
}

}  // namespace poise
