// SPDX-License-Identifier: MIT
#include "query/triangle_queries.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace poise::query {
namespace {

using geometry::TriangleCorners;

/// Distance that a point moves along a unit direction until it enters a convex body that it enters and leaves at these
/// distances. A point that rounding has put slightly inside enters at once if it moves toward the middle.
double entry_m(double enters_m, double leaves_m) {
  if (enters_m >= 0) return enters_m;
  return enters_m + leaves_m > 0 ? 0.0 : kMiss;
}

double to_ball_m(const Vec3& point, const Vec3& direction, const Vec3& center, double radius_m) {
  const BallCrossing crossing = crossing_of_ball(point, direction, center, radius_m);
  return crossing.enters_m == kMiss ? kMiss : entry_m(crossing.enters_m, crossing.leaves_m);
}

/// Distance to the lateral surface of the cylinder about the segment from a to b.
double to_mantle_m(const Vec3& point, const Vec3& direction, const Vec3& a, const Vec3& b, double radius_m) {
  const Vec3 side = b - a;
  const double length_m = side.norm();
  if (!(length_m > 0)) return kMiss;
  const Vec3 axis = side / length_m;
  const Vec3 from = point - a;
  const Vec3 across = direction - direction.dot(axis) * axis;
  const double speed2 = across.squaredNorm();
  if (!(speed2 > 1e-28)) return kMiss;  // along the axis: the balls at the ends decide
  const Vec3 off = from - from.dot(axis) * axis;
  const double nearest_m = -off.dot(across) / speed2;
  const double half2 = radius_m * radius_m - (off + nearest_m * across).squaredNorm();
  if (half2 < 0) return kMiss;
  const double half_m = std::sqrt(half2 / speed2);
  const double distance_m = entry_m(nearest_m - half_m, nearest_m + half_m);
  if (distance_m == kMiss) return kMiss;
  const double along_m = from.dot(axis) + distance_m * direction.dot(axis);
  return along_m >= 0 && along_m <= length_m ? distance_m : kMiss;
}

bool foot_inside(const Vec3& p, const TriangleCorners& t, const Vec3& normal) {
  for (std::size_t i = 0; i < 3; ++i) {
    if ((t[(i + 1) % 3] - t[i]).cross(p - t[i]).dot(normal) < 0) return false;
  }
  return true;
}

double to_face_m(const Vec3& point, double radius_m, const Vec3& direction, const TriangleCorners& t) {
  Vec3 normal = normal_of(t);
  if (normal.isZero(0)) return kMiss;
  double height_m = normal.dot(point - t[0]);
  Vec3 up = normal;
  if (height_m < 0) {
    height_m = -height_m;
    up = -normal;
  }
  const double closing = -up.dot(direction);
  if (!(closing > 0)) return kMiss;
  const double distance_m = std::max(0.0, (height_m - radius_m) / closing);
  return foot_inside(point + distance_m * direction, t, normal) ? distance_m : kMiss;
}

bool separated(const TriangleCorners& t, const Vec3& half, const Vec3& axis) {
  const double reach = half.dot(axis.cwiseAbs());
  const double p0 = axis.dot(t[0]);
  const double p1 = axis.dot(t[1]);
  const double p2 = axis.dot(t[2]);
  return std::min({p0, p1, p2}) > reach || std::max({p0, p1, p2}) < -reach;
}

}  // namespace

Vec3 normal_of(const TriangleCorners& t) {
  const Vec3 area = (t[1] - t[0]).cross(t[2] - t[0]);
  const double length = area.norm();
  if (!(length > 0)) return Vec3::Zero();
  return area / length;
}

TriangleRay::TriangleRay(const Vec3& origin_m, const Vec3& direction) : origin_m_(origin_m) {
  direction.cwiseAbs().maxCoeff(&z_);
  x_ = (z_ + 1) % 3;
  y_ = (x_ + 1) % 3;
  if (direction[z_] < 0) std::swap(x_, y_);
  shear_z_ = 1.0 / direction[z_];
  shear_x_ = direction[x_] * shear_z_;
  shear_y_ = direction[y_] * shear_z_;
}

double TriangleRay::distance_m(const TriangleCorners& t) const {
  const Vec3 a = t[0] - origin_m_;
  const Vec3 b = t[1] - origin_m_;
  const Vec3 c = t[2] - origin_m_;
  const double ax = a[x_] - shear_x_ * a[z_];
  const double ay = a[y_] - shear_y_ * a[z_];
  const double bx = b[x_] - shear_x_ * b[z_];
  const double by = b[y_] - shear_y_ * b[z_];
  const double cx = c[x_] - shear_x_ * c[z_];
  const double cy = c[y_] - shear_y_ * c[z_];
  const double u = cx * by - cy * bx;
  const double v = ax * cy - ay * cx;
  const double w = bx * ay - by * ax;
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return kMiss;
  const double sum = u + v + w;
  if (sum == 0) return kMiss;
  const double distance_m = shear_z_ * (u * a[z_] + v * b[z_] + w * c[z_]) / sum;
  return distance_m >= 0 ? distance_m : kMiss;
}

BallCrossing crossing_of_ball(const Vec3& origin_m, const Vec3& direction, const Vec3& center_m, double radius_m) {
  const Vec3 from = origin_m - center_m;
  const double nearest_m = -from.dot(direction);
  const double half2 = radius_m * radius_m - (from + nearest_m * direction).squaredNorm();
  if (!(half2 >= 0)) return {};
  const double half_m = std::sqrt(half2);
  return {nearest_m - half_m, nearest_m + half_m};
}

double sphere_to_triangle_m(const Vec3& center_m, double radius_m, const Vec3& direction, const TriangleCorners& t) {
  double least = to_face_m(center_m, radius_m, direction, t);
  // The offset face is met no later than any other part that contains its foot point.
  if (least < kMiss) return least;
  for (std::size_t i = 0; i < 3; ++i) {
    least = std::min(least, to_mantle_m(center_m, direction, t[i], t[(i + 1) % 3], radius_m));
    least = std::min(least, to_ball_m(center_m, direction, t[i], radius_m));
  }
  return least;
}

bool triangle_meets_box(const TriangleCorners& t, const Vec3& half_extents_m) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (separated(t, half_extents_m, Vec3::Unit(axis))) return false;
  }
  if (separated(t, half_extents_m, (t[1] - t[0]).cross(t[2] - t[0]))) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 edge = t[(i + 1) % 3] - t[i];
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (separated(t, half_extents_m, Vec3::Unit(axis).cross(edge))) return false;
    }
  }
  return true;
}

}  // namespace poise::query
