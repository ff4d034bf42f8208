// SPDX-License-Identifier: MIT
#include "scene/check/placed_bodies.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

namespace poise::io {
namespace {

constexpr int kDirections = 256;
/// Share of the smaller radius. Chosen: bodies of piles that were saved at rest overlap by less.
constexpr double kDeepBalls = 0.1;
constexpr double kNearCentres = 0.25;
/// Most bodies that are compared with all others. Chosen.
constexpr std::size_t kLargest = 256;

/// Direction k of a uniform set (Fibonacci spiral).
Vec3 direction(int k) {
  const double z = 1 - (2 * k + 1.0) / kDirections;
  const double turn = k * std::numbers::pi * (3 - std::sqrt(5.0));
  const double across = std::sqrt(std::max(0.0, 1 - z * z));
  return {across * std::cos(turn), across * std::sin(turn), z};
}

bool may_meet(const PlacedBody& a, const PlacedBody& b) {
  if (a.is_static && b.is_static) return false;
  return (a.group & b.collides_with) != 0 && (b.group & a.collides_with) != 0;
}

bool is_ball(const CheckedShape& shape) { return shape.shape->tree.node_count() == 1 && shape.triangles == 0; }

/// Penetration depth of two bodies; 0 if it is unknown or not deep.
double depth_of(const PlacedBody& a, const PlacedBody& b, std::span<const CheckedShape> shapes) {
  const double apart_m = (a.center_m - b.center_m).norm();
  const double smaller_m = std::min(a.radius_m, b.radius_m);
  const double depth_m = a.radius_m + b.radius_m - apart_m;
  const bool balls = is_ball(shapes[a.shape]) && is_ball(shapes[b.shape]);
  if (balls) return depth_m > kDeepBalls * smaller_m ? depth_m : 0;
  return apart_m < kNearCentres * smaller_m ? depth_m : 0;
}

double depth_in_plane(const PlacedBody& body, const PlacedBody& plane, std::span<const CheckedShape> shapes) {
  const Shape& half_space = *shapes[plane.shape].shape;
  const Vec3 normal = plane.orientation * half_space.plane_normal;
  const double height_m = normal.dot(body.center_m - plane.center_m) - half_space.plane_offset_m;
  if (height_m >= body.radius_m) return 0;
  double lowest_m = height_m;
  for (const Sphere& part : shapes[body.shape].outline)
    lowest_m = std::min(lowest_m, height_m + normal.dot(body.orientation * part.center_m) - part.radius_m);
  return height_m < 0 || -lowest_m > kDeepBalls * body.radius_m ? -lowest_m : 0;
}

/// Key of a grid cell in the search for neighbours. Two cells may share a key; then an additional pair is tested.
std::uint64_t cell_key(const Eigen::Array3d& cell) {
  std::uint64_t key = 0x9e3779b97f4a7c15U;
  for (const double part : {cell.x(), cell.y(), cell.z()})
    key = (key ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(std::clamp(part, -9e18, 9e18)))) *
          0xff51afd7ed558ccdU;
  return key ^ (key >> 32U);
}

}  // namespace

std::vector<Sphere> outline_of(std::span<const Sphere> parts) {
  if (parts.size() <= kDirections) return {parts.begin(), parts.end()};
  std::vector<std::size_t> chosen;
  for (int k = 0; k < kDirections; ++k) {
    const Vec3 along = direction(k);
    std::size_t best = 0;
    double reach_m = -1e300;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const double reaches_m = along.dot(parts[i].center_m) + parts[i].radius_m;
      if (reaches_m > reach_m) best = i;
      reach_m = std::max(reach_m, reaches_m);
    }
    chosen.push_back(best);
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  std::vector<Sphere> outline;
  for (const std::size_t i : chosen) outline.push_back(parts[i]);
  return outline;
}

std::vector<DeepPair> deep_pairs(std::span<const PlacedBody> bodies, std::span<const CheckedShape> shapes,
                                 std::size_t most) {
  std::vector<DeepPair> found;
  std::vector<std::size_t> planes, solids;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (!bodies[i].streamed) (bodies[i].plane ? planes : solids).push_back(i);
  }
  // Cells are so large that two overlapping bodies are in neighbouring ones. The few largest bodies are compared with
  // all others instead, so that they do not enlarge the cells.
  std::vector<double> radii_m;
  for (const std::size_t i : solids) radii_m.push_back(bodies[i].radius_m);
  std::sort(radii_m.begin(), radii_m.end());
  const double usual_m = radii_m.empty() ? 1 : radii_m[radii_m.size() - 1 - std::min(kLargest, radii_m.size() / 2)];
  const double cell_m = std::max(2 * usual_m, 1e-9);
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> cells;
  std::vector<std::size_t> large;
  for (const std::size_t i : solids) {
    const PlacedBody& body = bodies[i];
    const auto add = [&](std::size_t other) {
      if (found.size() >= most || !may_meet(body, bodies[other])) return;
      const double depth_m = depth_of(bodies[other], body, shapes);
      if (depth_m > 0) found.push_back({other, i, depth_m});
    };
    const Eigen::Array3d home = (body.center_m.array() / cell_m).floor();
    if (body.radius_m > usual_m) {
      for (std::size_t k = 0; solids[k] != i && found.size() < most; ++k) add(solids[k]);
      large.push_back(i);
    } else {
      for (const std::size_t other : large) add(other);
      for (int n = 0; n < 27; ++n) {
        const auto near = cells.find(cell_key(home + Eigen::Array3d(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1)));
        if (near == cells.end()) continue;
        for (const std::size_t other : near->second) add(other);
      }
      cells[cell_key(home)].push_back(i);
    }
    for (const std::size_t plane : planes) {
      if (found.size() >= most || !may_meet(body, bodies[plane])) continue;
      const double depth_m = depth_in_plane(body, bodies[plane], shapes);
      if (depth_m > 0) found.push_back({i, plane, depth_m});
    }
    if (found.size() >= most) break;
  }
  return found;
}

bool in_view(const View& view, const Vec3& center_m, double radius_m) {
  const Vec3 to = center_m - view.position_m;
  if (to.norm() <= radius_m) return true;
  const Vec3 right = view.forward.cross(view.up);
  const double half = 0.5 * view.vertical_fov_rad;
  const double across = std::atan(std::tan(half) * view.aspect);
  const double ahead_m = view.forward.dot(to);
  if (ahead_m < -radius_m) return false;
  for (const auto& [axis, angle] : {std::pair(view.up, half), std::pair(right, across)}) {
    // The distance beyond the side plane through the camera.
    if (std::abs(axis.dot(to)) * std::cos(angle) - ahead_m * std::sin(angle) > radius_m) return false;
  }
  return true;
}

}  // namespace poise::io
