// SPDX-License-Identifier: MIT
#include "geometry/primitives/triangle_distance.h"

#include <algorithm>
#include <cmath>

#include "geometry/bvh/triangle_bvh.h"

namespace poise::geometry {
namespace {

/// Six times the signed volume of a tetrahedron.
double volume6(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (b - a).cross(c - a).dot(d - a); }

bool edge_passes(const TriangleCorners& s, const TriangleCorners& t) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (segment_meets_triangle(s[i], s[(i + 1) % 3], t)) return true;
  }
  return false;
}

}  // namespace

bool segment_meets_triangle(const Vec3& from, const Vec3& to, const TriangleCorners& t) {
  const double side_from = volume6(t[0], t[1], t[2], from);
  const double side_to = volume6(t[0], t[1], t[2], to);
  if ((side_from > 0) == (side_to > 0) && side_from != 0 && side_to != 0) return false;
  if (side_from == side_to) return false;
  const double a = volume6(from, to, t[0], t[1]);
  const double b = volume6(from, to, t[1], t[2]);
  const double c = volume6(from, to, t[2], t[0]);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

double squared_distance_of_segments_m2(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  const Vec3 d1 = q - p;
  const Vec3 d2 = s - r;
  const Vec3 between = p - r;
  const double a = d1.squaredNorm();
  const double e = d2.squaredNorm();
  const double f = d2.dot(between);
  double on_first = 0;
  double on_second = 0;
  if (a > 0 && e > 0) {
    const double b = d1.dot(d2);
    const double c = d1.dot(between);
    const double across = a * e - b * b;
    // Nearly parallel: any point of the first segment is valid; the second follows, clamped.
    if (across > 1e-14 * a * e) on_first = std::clamp((b * f - c * e) / across, 0.0, 1.0);
    on_second = (b * on_first + f) / e;
    if (on_second < 0) {
      on_second = 0;
      on_first = std::clamp(-c / a, 0.0, 1.0);
    } else if (on_second > 1) {
      on_second = 1;
      on_first = std::clamp((b - c) / a, 0.0, 1.0);
    }
  } else if (a > 0) {
    on_first = std::clamp(-d1.dot(between) / a, 0.0, 1.0);
  } else if (e > 0) {
    on_second = std::clamp(f / e, 0.0, 1.0);
  }
  return (p + on_first * d1 - r - on_second * d2).squaredNorm();
}

double distance_of_triangles_m(const TriangleCorners& s, const TriangleCorners& t) {
  double least2 = (s[0] - t[0]).squaredNorm();
  for (std::size_t i = 0; i < 3; ++i) {
    least2 = std::min(least2, (closest_on_triangle(s[i], t) - s[i]).squaredNorm());
    least2 = std::min(least2, (closest_on_triangle(t[i], s) - t[i]).squaredNorm());
    for (std::size_t j = 0; j < 3; ++j) {
      least2 = std::min(least2, squared_distance_of_segments_m2(s[i], s[(i + 1) % 3], t[j], t[(j + 1) % 3]));
    }
  }
  if (least2 == 0 || edge_passes(s, t) || edge_passes(t, s)) return 0;
  return std::sqrt(least2);
}

}  // namespace poise::geometry
