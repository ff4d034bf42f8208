// SPDX-License-Identifier: MIT
#include "geometry/shape/shape_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/mesh/mesh_edges.h"
#include "math/functions.h"

namespace poise::geometry {
namespace {

using SurfaceTriangle = ShapeSurface::Triangle;

// Sine of the angle of an edge that counts as flat. Chosen: far above the rounding of files in single precision, far
// below the bends of a round mesh of a million triangles (2e-3).
constexpr double kFlat = 1e-6;
// Spheres are enlarged by this share of the radius: more than the rounding of a distance.
constexpr double kSpare = 1e-9;

void set_triangles(const TriangleMesh& mesh, ShapeSurface& surface) {
  surface.triangles.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    SurfaceTriangle& t = surface.triangles[i];
    t.vertex = mesh.triangles[i];
    t.across.fill(ShapeSurface::kNone);
    const Vec3& p = surface.vertices_m[t.vertex[0]];
    const Vec3& q = surface.vertices_m[t.vertex[1]];
    const Vec3& r = surface.vertices_m[t.vertex[2]];
    const Vec3 across = (q - p).cross(r - p);
    const double length = across.norm();
    if (length > 0) t.normal = across / length;
    // The ball with the longest side as its diameter, enlarged to contain the third corner.
    const std::array<double, 3> length2{(q - p).squaredNorm(), (r - q).squaredNorm(), (p - r).squaredNorm()};
    const auto longest = static_cast<std::size_t>(std::ranges::max_element(length2) - length2.begin());
    t.center_m = 0.5 * (surface.vertices_m[t.vertex[longest]] + surface.vertices_m[t.vertex[(longest + 1) % 3]]);
    for (const std::uint32_t v : t.vertex)
      t.radius_m = std::max(t.radius_m, (surface.vertices_m[v] - t.center_m).norm());
    t.radius_m *= 1 + kSpare;
  }
}

void set_triangle_bounds(ShapeSurface& surface) {
  // Each length results from a few roundings of numbers no larger than the farthest coordinate.
  constexpr double kRoundings = 16;
  double farthest = 0;
  for (const SurfaceTriangle& t : surface.triangles) {
    const Vec3& c = t.center_m;
    surface.triangle_bounds.push_back(
        {{static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z())},
         static_cast<float>(t.radius_m),
         {static_cast<float>(t.normal.x()), static_cast<float>(t.normal.y()), static_cast<float>(t.normal.z())},
         0.0F});
    farthest = std::max(farthest, c.norm() + t.radius_m);
  }
  surface.rounding_m =
      static_cast<float>(kRoundings * static_cast<double>(std::numeric_limits<float>::epsilon()) * farthest);
}

void set_vertex_normals(ShapeSurface& surface) {
  surface.vertex_normal.assign(surface.vertices_m.size(), Vec3::Zero());
  for (const SurfaceTriangle& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& at = surface.vertices_m[t.vertex[k]];
      const Vec3 u = surface.vertices_m[t.vertex[(k + 1) % 3]] - at;
      const Vec3 v = surface.vertices_m[t.vertex[(k + 2) % 3]] - at;
      surface.vertex_normal[t.vertex[k]] += math::atan2(u.cross(v).norm(), u.dot(v)) * t.normal;
    }
  }
  for (Vec3& normal : surface.vertex_normal) {
    const double length = normal.norm();
    if (length > 0) normal /= length;
  }
}

std::size_t side_of(const SurfaceTriangle& t, const EdgeUse& use) {
  const std::uint32_t from = use.direction > 0 ? use.low : use.high;
  return static_cast<std::size_t>(std::ranges::find(t.vertex, from) - t.vertex.begin());
}

// Whether another body can touch this side of t first. The triangle across it is `other`.
bool stands_out(const ShapeSurface& surface, const SurfaceTriangle& t, const EdgeUse& use,
                const SurfaceTriangle& other) {
  for (const std::uint32_t v : other.vertex) {
    if (v == use.low || v == use.high) continue;
    const Vec3 away = surface.vertices_m[v] - surface.vertices_m[use.low];
    const double side = t.normal.dot(away);
    const double flat = kFlat * away.norm();
    return surface.solid ? side < -flat : std::abs(side) > flat;
  }
  return true;
}

// Sets the neighbours across the sides, and which sides and corners can touch first.
void set_edges(ShapeSurface& surface, std::span<const EdgeUse> uses) {
  std::vector<char> sharp(surface.vertices_m.size(), 0);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    bool out = edge.size() != 2;
    if (edge.size() == 2) {
      SurfaceTriangle& t = surface.triangles[edge[0].triangle];
      SurfaceTriangle& u = surface.triangles[edge[1].triangle];
      t.across[side_of(t, edge[0])] = edge[1].triangle;
      u.across[side_of(u, edge[1])] = edge[0].triangle;
      // A needle without area has no normal to compare with: its sides are included.
      out = t.normal.isZero(0) || u.normal.isZero(0) || stands_out(surface, t, edge[0], u);
    }
    if (!out) return;
    SurfaceTriangle& owner = surface.triangles[edge[0].triangle];
    owner.features = static_cast<std::uint8_t>(owner.features | ShapeSurface::kEdge0 << side_of(owner, edge[0]));
    sharp[edge[0].low] = sharp[edge[0].high] = 1;
  });
  for (SurfaceTriangle& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (sharp[t.vertex[k]] == 0) continue;
      sharp[t.vertex[k]] = 0;
      t.features = static_cast<std::uint8_t>(t.features | ShapeSurface::kVertex0 << k);
    }
  }
}

// An angle of at least that between two unit vectors, from the chord c between them: 2 asin(c / 2) < 1.05 c up to c
// = 1.
double widest_angle_rad(const Vec3& u, const Vec3& v) {
  const double chord = (u - v).norm();
  return u.isZero(0) || v.isZero(0) || chord > 1 ? static_cast<double>(ShapeSurface::kAnyDirection) : 1.05 * chord;
}

// A plane that supports the surface at a corner or a side leans from a face no more than the steepest of the faces
// around does, so the angles between the normals bound the directions.
void set_spreads(ShapeSurface& surface) {
  if (!surface.solid) return;
  std::vector<std::uint32_t> owner(surface.vertices_m.size(), ShapeSurface::kNone);
  std::vector<double> spread(surface.triangles.size(), 0);
  for (std::uint32_t index = 0; index < surface.triangles.size(); ++index) {
    const SurfaceTriangle& t = surface.triangles[index];
    for (std::size_t k = 0; k < 3; ++k) {
      if ((t.features & (ShapeSurface::kVertex0 << k)) != 0) owner[t.vertex[k]] = index;
      if ((t.features & (ShapeSurface::kEdge0 << k)) == 0) continue;
      const double there = t.across[k] == ShapeSurface::kNone
                               ? static_cast<double>(ShapeSurface::kAnyDirection)
                               : widest_angle_rad(t.normal, surface.triangles[t.across[k]].normal);
      spread[index] = std::max(spread[index], there);
    }
  }
  for (const SurfaceTriangle& t : surface.triangles) {
    for (const std::uint32_t vertex : t.vertex) {
      const std::uint32_t at = owner[vertex];
      if (at == ShapeSurface::kNone) continue;
      spread[at] = std::max(spread[at], widest_angle_rad(surface.triangles[at].normal, t.normal));
    }
  }
  for (std::size_t i = 0; i < spread.size(); ++i) {
    surface.triangles[i].spread_rad =
        static_cast<float>(std::min(spread[i] * (1 + 1e-6), static_cast<double>(ShapeSurface::kAnyDirection)));
  }
}

void set_neighbors(ShapeSurface& surface, std::span<const EdgeUse> uses) {
  std::vector<std::uint32_t>& begin = surface.neighbor_begin;
  begin.assign(surface.vertices_m.size() + 1, 0);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    ++begin[edge[0].low + 1];
    ++begin[edge[0].high + 1];
  });
  for (std::size_t v = 1; v < begin.size(); ++v) begin[v] += begin[v - 1];
  surface.neighbors.resize(begin.back());
  std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    surface.neighbors[at[edge[0].low]++] = edge[0].high;
    surface.neighbors[at[edge[0].high]++] = edge[0].low;
  });
  for (std::size_t v = 0; v + 1 < begin.size(); ++v) {
    std::sort(surface.neighbors.begin() + begin[v], surface.neighbors.begin() + begin[v + 1]);
  }
}

// Sets which leaves each triangle overlaps, and the reverse.
void set_leaves(const SphereTree& tree, ShapeSurface& surface) {
  std::vector<std::uint32_t> near;
  surface.leaf_begin.assign(tree.node_count() + 1, 0);
  surface.triangle_leaf_begin.assign(surface.triangles.size() + 1, 0);
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    surface.leaf_begin[node] = static_cast<std::uint32_t>(surface.leaf_triangles.size());
    if (tree.child_count[node] != 0) continue;
    const Sphere leaf = tree.sphere(node);
    const double reach_m = leaf.radius_m * (1 + kSpare);
    near.clear();
    surface.bvh.triangles_near(leaf.center_m, reach_m, near);
    std::erase_if(near, [&](std::uint32_t t) {
      return (closest_on_triangle(leaf.center_m, surface.bvh.corners(t)) - leaf.center_m).squaredNorm() >
             reach_m * reach_m;
    });
    std::sort(near.begin(), near.end());
    surface.leaf_triangles.insert(surface.leaf_triangles.end(), near.begin(), near.end());
    for (const std::uint32_t t : near) ++surface.triangle_leaf_begin[t + 1];
  }
  surface.leaf_begin.back() = static_cast<std::uint32_t>(surface.leaf_triangles.size());
  std::vector<std::uint32_t>& begin = surface.triangle_leaf_begin;
  for (std::size_t t = 1; t < begin.size(); ++t) begin[t] += begin[t - 1];
  surface.triangle_leaves.resize(begin.back());
  std::vector<std::uint32_t> at(begin.begin(), begin.end() - 1);
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    for (const std::uint32_t t : surface.triangles_of(node)) surface.triangle_leaves[at[t]++] = node;
  }
}

void set_near_triangles(ShapeSurface& surface) {
  surface.near_triangles.resize(surface.triangles.size());
  for (std::uint32_t place = 0; place < surface.near_triangles.size(); ++place) {
    const SurfaceTriangle& t = surface.triangles[surface.bvh.triangle_at(place)];
    ShapeSurface::NearTriangle& near = surface.near_triangles[place];
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3f corner = (surface.vertices_m[t.vertex[k]] - surface.bvh.origin_m()).cast<float>();
      near.corner[k] = {corner.x(), corner.y(), corner.z(), static_cast<float>(t.normal[static_cast<Eigen::Index>(k)])};
    }
    near.features = static_cast<float>(t.features);
    near.spread_rad = t.spread_rad;
    near.unused = {};
  }
}

TriangleMesh moved(const TriangleMesh& mesh, const Vec3& offset_m) {
  TriangleMesh result = mesh;
  for (Vec3& v : result.vertices_m) v -= offset_m;
  return result;
}

}  // namespace

ShapeSurface make_surface(const TriangleMesh& mesh, const Vec3& offset_m, Solidity solidity, const SphereTree& tree) {
  const TriangleMesh there = moved(mesh, offset_m);
  ShapeSurface surface(TriangleBvh(there, solidity));
  surface.solid = solidity == Solidity::Solid && surface.bvh.closed();
  surface.vertices_m = there.vertices_m;
  set_triangles(there, surface);
  set_triangle_bounds(surface);
  set_vertex_normals(surface);
  const std::vector<EdgeUse> uses = edge_uses(there.triangles);
  set_edges(surface, uses);
  set_spreads(surface);
  set_near_triangles(surface);
  set_neighbors(surface, uses);
  set_leaves(tree, surface);
  return surface;
}

}  // namespace poise::geometry
