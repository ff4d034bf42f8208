// SPDX-License-Identifier: MIT
#include "geometry/mesh/bumpy_ball.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "math/functions.h"

namespace poise::geometry {
namespace {

using Index = std::uint32_t;

/// Distance of the surface from the middle in a direction, from 0.25 to 0.5 m; the three waves add up at the horns.
double reach_m(const Vec3& direction) {
  const double waves =
      math::sin(5 * direction.x() + 0.4) + math::sin(4 * direction.y() + 1.1) + math::sin(6 * direction.z() + 2.3);
  return 0.375 + 0.125 / 3 * waves;
}

struct Icosahedron {
  std::array<Vec3, 12> corners;
  std::array<std::array<Index, 3>, 20> faces;
};

Icosahedron icosahedron() {
  const double g = std::numbers::phi;
  return {{{{-1, g, 0},
            {1, g, 0},
            {-1, -g, 0},
            {1, -g, 0},
            {0, -1, g},
            {0, 1, g},
            {0, -1, -g},
            {0, 1, -g},
            {g, 0, -1},
            {g, 0, 1},
            {-g, 0, -1},
            {-g, 0, 1}}},
          {{{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
            {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
            {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}}};
}

/// Creates each vertex of the subdivided faces once. Those of an edge are shared by two faces, those of a corner by
/// five.
class Cutter {
 public:
  explicit Cutter(Index parts) : parts_(parts), solid_(icosahedron()) {}

  TriangleMesh cut() {
    for (Index c = 0; c < solid_.corners.size(); ++c) add(solid_.corners[c]);
    for (const auto& face : solid_.faces) cut_face(face);
    return std::move(mesh_);
  }

 private:
  Index add(const Vec3& point) {
    const Vec3 direction = point.normalized();
    mesh_.vertices_m.emplace_back(reach_m(direction) * direction);
    return static_cast<Index>(mesh_.vertices_m.size() - 1);
  }

  /// Vertices of an edge from its lower-numbered corner on, both corners included.
  const std::vector<Index>& edge(Index a, Index b) {
    const auto [place, is_new] = edges_.try_emplace({a, b});
    if (is_new) {
      place->second.push_back(a);
      for (Index i = 1; i < parts_; ++i) {
        const double share = static_cast<double>(i) / parts_;
        place->second.push_back(add((1 - share) * solid_.corners[a] + share * solid_.corners[b]));
      }
      place->second.push_back(b);
    }
    return place->second;
  }
  /// Vertex `i` of the edge as seen from corner a.
  Index along(Index a, Index b, Index i) { return a < b ? edge(a, b)[i] : edge(b, a)[parts_ - i]; }

  /// Row r of a face has r + 1 vertices; row 0 is its first corner.
  void cut_face(const std::array<Index, 3>& face) {
    std::vector<Index> above{face[0]};
    for (Index r = 1; r <= parts_; ++r) {
      std::vector<Index> row{along(face[0], face[1], r)};
      for (Index i = 1; i < r; ++i) row.push_back(r == parts_ ? along(face[1], face[2], i) : add(inner(face, r, i)));
      row.push_back(along(face[0], face[2], r));
      for (Index i = 0; i < r; ++i) {
        mesh_.triangles.push_back({above[i], row[i], row[i + 1]});
        if (i + 1 < r) mesh_.triangles.push_back({above[i], row[i + 1], above[i + 1]});
      }
      above = std::move(row);
    }
  }
  [[nodiscard]] Vec3 inner(const std::array<Index, 3>& face, Index r, Index i) const {
    const double to_c = static_cast<double>(i) / parts_;
    const double to_b = static_cast<double>(r - i) / parts_;
    return (1 - to_b - to_c) * solid_.corners[face[0]] + to_b * solid_.corners[face[1]] +
           to_c * solid_.corners[face[2]];
  }

  Index parts_;
  Icosahedron solid_;
  TriangleMesh mesh_;
  std::map<std::pair<Index, Index>, std::vector<Index>> edges_;
};

}  // namespace

Result<TriangleMesh> bumpy_ball(std::size_t triangles) {
  if (triangles < 1 || triangles > 20000000)
    return bad_input(fmt::format("triangles = {}, must be from 1 to 20000000", triangles));
  Index parts = 1;
  while (std::size_t{20} * parts * parts < triangles) ++parts;
  return Cutter(parts).cut();
}

}  // namespace poise::geometry
