// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "geometry/mesh/procedural.h"
#include "math/functions.h"

namespace poise::geometry {
namespace {

// Corner i is at the far end along x, y, z where its bits 1, 2, 4 are set.
TriangleMesh block_of(const std::array<Vec3, 8>& corners) {
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  TriangleMesh mesh;
  for (const Vec3& corner : corners) {
    Vec3 rounded;
    for (int k = 0; k < 3; ++k) rounded[k] = std::round(corner[k] * 1e9) / 1e9 + 0.0;
    mesh.vertices_m.push_back(rounded);
  }
  for (const auto& f : kFaces) {
    mesh.triangles.push_back({f[0], f[1], f[2]});
    mesh.triangles.push_back({f[0], f[2], f[3]});
  }
  return mesh;
}

Status check_length(const char* name, double length_m) {
  if (length_m >= kLeastBlockM && length_m <= kMostBlockM) return Done{};
  return bad_input(fmt::format("{} = {}, must be from {} to {} m", name, length_m, kLeastBlockM, kMostBlockM));
}

}  // namespace

Result<TriangleMesh> make_box(const Vec3& size_m) {
  for (int k = 0; k < 3; ++k) {
    const Status sound = check_length("size", size_m[k]);
    if (!sound) return sound.error();
  }
  std::array<Vec3, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    const Vec3 side((i & 1U) != 0 ? 1 : -1, (i & 2U) != 0 ? 1 : -1, (i & 4U) != 0 ? 1 : -1);
    corners[i] = 0.5 * side.cwiseProduct(size_m);
  }
  return block_of(corners);
}

Result<TriangleMesh> make_wedge(const WedgeSize& size) {
  for (const auto& [name, length_m] :
       {std::pair{"inner", size.inner_m}, std::pair{"outer", size.outer_m}, std::pair{"depth", size.depth_m}}) {
    const Status sound = check_length(name, length_m);
    if (!sound) return sound.error();
  }
  if (!(size.outer_m - size.inner_m >= kLeastBlockM)) {
    return bad_input(fmt::format("outer = {}, must be more than inner = {}", size.outer_m, size.inner_m));
  }
  if (!(size.angle_deg >= 0.1 && size.angle_deg <= 90))
    return bad_input(fmt::format("angle = {}, must be from 0.1 to 90 degrees", size.angle_deg));
  const double half_rad = 0.5 * size.angle_deg * std::numbers::pi / 180;
  std::array<Vec3, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    const double radius_m = (i & 4U) != 0 ? size.outer_m : size.inner_m;
    const double angle_rad = (i & 1U) != 0 ? half_rad : -half_rad;
    corners[i] = Vec3(radius_m * math::sin(angle_rad), (i & 2U) != 0 ? 0.5 * size.depth_m : -0.5 * size.depth_m,
                      radius_m * math::cos(angle_rad));
  }
  return block_of(corners);
}

}  // namespace poise::geometry
