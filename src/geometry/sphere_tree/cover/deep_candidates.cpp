// SPDX-License-Identifier: MIT
#include "geometry/sphere_tree/cover/deep_candidates.h"

#include <algorithm>
#include <cmath>

#include "geometry/primitives/random.h"

namespace poise::geometry {
namespace {

constexpr int kShrinkings = 12;
constexpr int kClimbs = 10;

/// Shrinks a ball that touches the surface at p, on the side opposite to the normal, until no surface is inside it.
DeepPoint shrink(const TriangleBvh& bvh, const CoverFrame& frame, const Vec3& p, const Vec3& normal) {
  double radius_m = 0.5 * frame.diagonal_m;
  for (int i = 0; i < kShrinkings; ++i) {
    const Vec3 center = p - radius_m * normal;
    const auto closest = bvh.closest(center, radius_m * radius_m * (1 - 2e-6));
    if (closest.triangle == TriangleBvh::kNoTriangle) break;
    const Vec3 way = p - closest.point_m;
    const double along = 2 * normal.dot(way);
    if (along <= 1e-12 * frame.diagonal_m) break;
    radius_m = std::min(radius_m, way.squaredNorm() / along);
  }
  const Vec3 center = p - radius_m * normal;
  return {frame.to(center), static_cast<float>(radius_m / frame.diagonal_m)};
}

/// Moves a point away from its closest surface point while that increases its depth. Balls that touch a facet near a
/// convex edge are shallow even for a fine mesh; this moves them to the middle of the part.
DeepPoint climb(const TriangleBvh& bvh, const CoverFrame& frame, const DeepPoint& from) {
  Vec3 place = frame.from(from.center);
  auto closest = bvh.closest(place);
  double depth_m = std::sqrt(closest.squared_distance_m2);
  double step_m = 0.5 * depth_m;
  for (int i = 0; i < kClimbs && depth_m > 0; ++i) {
    const Vec3 tried = place + step_m / depth_m * (place - closest.point_m);
    const auto next = bvh.closest(tried);
    if (next.squared_distance_m2 > depth_m * depth_m) {
      place = tried;
      closest = next;
      depth_m = std::sqrt(next.squared_distance_m2);
    } else {
      step_m *= 0.5;
    }
  }
  const Vec3f center = frame.to(place);
  return {center,
          static_cast<float>(std::sqrt(bvh.closest(frame.from(center)).squared_distance_m2) / frame.diagonal_m)};
}

}  // namespace

std::vector<DeepPoint> find_deep_points(const TriangleMesh& mesh, const TriangleBvh& bvh, const CoverFrame& frame,
                                        std::size_t count, std::uint64_t seed, parallel::Executor& executor) {
  std::vector<double> area_until;
  double area = 0;
  for (const auto& t : mesh.triangles) {
    area += (mesh.vertices_m[t[1]] - mesh.vertices_m[t[0]]).cross(mesh.vertices_m[t[2]] - mesh.vertices_m[t[0]]).norm();
    area_until.push_back(area);
  }
  std::vector<DeepPoint> points(count);
  parallel::parallel_for(executor, count, 32, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      Random random = Random::of(seed, i);
      const double at = (static_cast<double>(i) + random.unit()) / static_cast<double>(count) * area;
      const auto found = std::ranges::upper_bound(area_until, at) - area_until.begin();
      const auto& t = mesh.triangles[std::min(static_cast<std::size_t>(found), mesh.triangles.size() - 1)];
      const double u = std::sqrt(random.unit());
      const double v = random.unit();
      const Vec3& a = mesh.vertices_m[t[0]];
      const Vec3& b = mesh.vertices_m[t[1]];
      const Vec3& c = mesh.vertices_m[t[2]];
      const Vec3 p = (1 - u) * a + u * (1 - v) * b + u * v * c;
      const Vec3 normal = (b - a).cross(c - a).normalized();
      points[i] = {frame.to(p), 0.0F};
      if (!normal.allFinite() || normal.squaredNorm() < 0.5) continue;
      const DeepPoint deep = shrink(bvh, frame, p, normal);
      if (!bvh.inside(frame.from(deep.center))) continue;
      // Half of the points climb: deep balls cover most of the object, and the others cover the ends of its parts.
      const DeepPoint higher = i % 2 == 0 ? climb(bvh, frame, deep) : deep;
      points[i] = bvh.inside(frame.from(higher.center)) ? higher : deep;
    }
  });
  return points;
}

}  // namespace poise::geometry
