// SPDX-License-Identifier: MIT
#include "collision/triangles/convex_gap.h"

#include <algorithm>
#include <limits>

#include "geometry/bvh/triangle_bvh.h"
#include "geometry/primitives/triangle_distance.h"

namespace poise::collision {
namespace {

using geometry::TriangleCorners;

struct NearestPoints {
  double squared_m2 = std::numeric_limits<double>::infinity();
  Vec3 on_a = Vec3::Zero(), on_b = Vec3::Zero();
  void offer(const Vec3& a, const Vec3& b) {
    const double squared = (b - a).squaredNorm();
    if (squared < squared_m2) *this = {squared, a, b};
  }
};

// The nearest points of p + s (q - p) and r + t (u - r), s and t in [0, 1]; both of some length.
void offer_sides(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& u, NearestPoints& best) {
  const Vec3 d = q - p;
  const Vec3 e = u - r;
  const Vec3 w = p - r;
  const double dd = d.dot(d);
  const double ee = e.dot(e);
  const double de = d.dot(e);
  if (dd <= 0 || ee <= 0) return;  // corners answer for sides without length
  const double across = dd * ee - de * de;
  double s = across > 1e-14 * dd * ee ? std::clamp((de * e.dot(w) - d.dot(w) * ee) / across, 0.0, 1.0) : 0.0;
  const double t = std::clamp((de * s + e.dot(w)) / ee, 0.0, 1.0);
  s = std::clamp((de * t - d.dot(w)) / dd, 0.0, 1.0);
  best.offer(p + s * d, r + t * e);
}

NearestPoints nearest_of_triangles(const TriangleCorners& a, const TriangleCorners& b) {
  NearestPoints best;
  for (std::size_t i = 0; i < 3; ++i) {
    best.offer(a[i], geometry::closest_on_triangle(a[i], b));
    best.offer(geometry::closest_on_triangle(b[i], a), b[i]);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) offer_sides(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3], best);
  }
  return best;
}

bool pass_through(const TriangleCorners& a, const TriangleCorners& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (geometry::segment_meets_triangle(a[i], a[(i + 1) % 3], b)) return true;
    if (geometry::segment_meets_triangle(b[i], b[(i + 1) % 3], a)) return true;
  }
  return false;
}

}  // namespace

ConvexGap gap_of(const ConvexPart& a, const ConvexPart& b) {
  NearestPoints near;
  if (a.corners == 1 && b.corners == 1) {
    near.offer(a.corner_m[0], b.corner_m[0]);
  } else if (a.corners == 1) {
    near.offer(a.corner_m[0], geometry::closest_on_triangle(a.corner_m[0], b.corner_m));
  } else if (b.corners == 1) {
    near.offer(geometry::closest_on_triangle(b.corner_m[0], a.corner_m), b.corner_m[0]);
  } else {
    near = nearest_of_triangles(a.corner_m, b.corner_m);
    if (pass_through(a.corner_m, b.corner_m)) return {0, Vec3::Zero(), 0.5 * (near.on_a + near.on_b)};
  }
  const Vec3 between = near.on_b - near.on_a;
  const double distance = between.norm();
  ConvexGap gap;
  if (distance > 0) gap.normal = between / distance;
  gap.gap_m = distance - a.radius_m - b.radius_m;
  gap.point_m = 0.5 * (near.on_a + near.on_b + (a.radius_m - b.radius_m) * gap.normal);
  return gap;
}

ConvexGap gap_to_plane(const ConvexPart& a, const Vec3& normal, double height_m) {
  // Corners that are equally low share the touch, so that a face that lies flat is met in its middle.
  constexpr double kEqual = 1e-9;
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  for (const Vec3& corner : a.all()) least = std::min(least, normal.dot(corner));
  for (const Vec3& corner : a.all()) most = std::max(most, (corner - a.corner_m[0]).norm());
  Vec3 sum = Vec3::Zero();
  double count = 0;
  for (const Vec3& corner : a.all()) {
    if (normal.dot(corner) > least + kEqual * most) continue;
    sum += corner;
    count += 1;
  }
  ConvexGap gap;
  gap.gap_m = least - height_m - a.radius_m;
  gap.normal = -normal;
  gap.point_m = sum / count - (a.radius_m + 0.5 * gap.gap_m) * normal;
  return gap;
}

}  // namespace poise::collision
