// SPDX-License-Identifier: MIT
#include "geometry/mesh/solids.h"

#include <cstdint>
#include <numbers>
#include <vector>

#include "math/functions.h"

namespace poise::geometry {
namespace {

constexpr std::uint32_t kAround = 32;
constexpr std::uint32_t kCapRings = 8;  ///< of half a ball, its rim included and its tip not

/// A ring of a solid of revolution: distance from the axis, height.
struct Ring {
  double out, height;
};

/// Closes a row of rings, from below, by a tip at each end.
TriangleMesh revolved(double bottom, const std::vector<Ring>& rings, double top) {
  TriangleMesh mesh;
  mesh.vertices_m.emplace_back(0, 0, bottom);
  for (const Ring& ring : rings) {
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const math::SinCos turn = math::sin_cos(2 * std::numbers::pi * i / kAround);
      mesh.vertices_m.emplace_back(ring.out * turn.cos, ring.out * turn.sin, ring.height);
    }
  }
  mesh.vertices_m.emplace_back(0, 0, top);
  const auto at = [](std::uint32_t ring, std::uint32_t i) { return 1 + ring * kAround + i % kAround; };
  const auto last = static_cast<std::uint32_t>(rings.size()) - 1;
  const std::uint32_t tip = 1 + (last + 1) * kAround;
  for (std::uint32_t i = 0; i < kAround; ++i) {
    mesh.triangles.push_back({0, at(0, i + 1), at(0, i)});
    for (std::uint32_t ring = 0; ring < last; ++ring) {
      mesh.triangles.push_back({at(ring, i), at(ring, i + 1), at(ring + 1, i + 1)});
      mesh.triangles.push_back({at(ring, i), at(ring + 1, i + 1), at(ring + 1, i)});
    }
    mesh.triangles.push_back({at(last, i), at(last, i + 1), tip});
  }
  return mesh;
}

/// Two half balls of radius 1 whose rims are at -half and half; of a whole ball they share one.
TriangleMesh rounded(double half) {
  std::vector<Ring> rings;
  for (std::uint32_t k = 1; k <= kCapRings; ++k) {
    const math::SinCos turn = math::sin_cos(0.5 * std::numbers::pi * k / kCapRings);
    rings.push_back({turn.sin, -half - turn.cos});
  }
  rings.back() = {1, -half};
  if (half > 0) rings.push_back({1, half});
  for (std::uint32_t k = kCapRings - 1; k > 0; --k) rings.push_back({rings[k - 1].out, -rings[k - 1].height});
  return revolved(-half - 1, rings, half + 1);
}

void scale(const Vec3& factors, TriangleMesh& mesh) {
  for (Vec3& v : mesh.vertices_m) v = v.cwiseProduct(factors);
}

}  // namespace

TriangleMesh box_solid(const Vec3& half_m) {
  TriangleMesh mesh;
  for (unsigned k = 0; k < 8; ++k)
    mesh.vertices_m.emplace_back(k & 1U ? half_m.x() : -half_m.x(), k & 2U ? half_m.y() : -half_m.y(),
                                 k & 4U ? half_m.z() : -half_m.z());
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

TriangleMesh ellipsoid_solid(const Vec3& radii_m) {
  TriangleMesh mesh = rounded(0);
  scale(radii_m, mesh);
  return mesh;
}

TriangleMesh cylinder_solid(double radius_m, double half_m) {
  return revolved(-half_m, {{radius_m, -half_m}, {radius_m, half_m}}, half_m);
}

TriangleMesh capsule_solid(double radius_m, double half_m) {
  TriangleMesh mesh = rounded(half_m / radius_m);
  scale(Vec3::Constant(radius_m), mesh);
  return mesh;
}

}  // namespace poise::geometry
