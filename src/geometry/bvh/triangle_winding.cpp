// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <numbers>

#include "geometry/bvh/triangle_bvh.h"
#include "math/functions.h"

namespace poise::geometry {
namespace {

/// A cluster is replaced by a dipole at distances above this multiple of its reach (the paper's choice). Errors reached
/// 0.2 on a thin bowl.
constexpr float kDipoleFrom = 2;
/// The same if the first result is near a half; the error falls with its square.
constexpr float kDipoleFromNearHalf = 5;
constexpr double kUnsure = 0.25;
constexpr std::size_t kMaxWindingStack = 256;

/// A sum of solid angles. Half of each angle is the argument of a complex number; arguments are added by
/// multiplication, with full turns counted separately. So one arc tangent is enough for all triangles.
class SolidAngles {
 public:
  // Invariant: the sum so far is 2 * (argument of (real_, imaginary_) + 2 pi turns_).
  void add(const Vec3& p, const TriangleCorners& t) {
    const Vec3 a = t[0] - p;
    const Vec3 b = t[1] - p;
    const Vec3 c = t[2] - p;
    const double la = a.norm();
    const double lb = b.norm();
    const double lc = c.norm();
    const double above = a.dot(b.cross(c)) + 0.0;  // no negative zero
    const double below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    const double size = std::abs(above) + std::abs(below);
    if (!(size > 0)) return;
    const double real = (real_ * below - imaginary_ * above) / size;
    const double imaginary = (real_ * above + imaginary_ * below) / size + 0.0;
    if (imaginary_ >= 0 && above >= 0) turns_ += imaginary < 0 ? 1 : 0;
    if (imaginary_ < 0 && above < 0) turns_ -= imaginary >= 0 ? 1 : 0;
    const double scale = 1 / (std::abs(real) + std::abs(imaginary));
    real_ = real * scale;
    imaginary_ = imaginary * scale;
  }
  /// The sum as a share of the full sphere.
  [[nodiscard]] double winding() const { return math::atan2(imaginary_, real_) / (2 * std::numbers::pi) + turns_; }

 private:
  double real_ = 1;
  double imaginary_ = 0;
  int turns_ = 0;
};

/// Direction in which an edge a-b crosses the half-line from p along u: up (+1), down (-1) or none (0). The end above p
/// is always used second, so that both triangles of an edge compute with the same numbers.
int crossing(const Vec3& a, const Vec3& b, const Vec3& p, Eigen::Index u, Eigen::Index v) {
  const bool a_above = a[v] > p[v];
  const bool b_above = b[v] > p[v];
  if (a_above == b_above) return 0;
  const Vec3& low = a_above ? b : a;
  const Vec3& high = a_above ? a : b;
  const double left = (high[u] - low[u]) * (p[v] - low[v]) - (p[u] - low[u]) * (high[v] - low[v]);
  if (!(left > 0)) return 0;
  return b_above ? 1 : -1;
}

}  // namespace

int TriangleBvh::crossings(const Vec3& point) const {
  if (!((point.array() >= box_.low.array()) && (point.array() <= box_.high.array())).all()) return 0;
  // Uses the axis and direction along which the distance to the end of the box is shortest.
  Eigen::Index up_axis = 0;
  Eigen::Index down_axis = 0;
  const double up_m = (box_.high - point).minCoeff(&up_axis);
  const double down_m = (point - box_.low).minCoeff(&down_axis);
  const bool forward = up_m <= down_m;
  const Eigen::Index k = forward ? up_axis : down_axis;
  const Eigen::Index u = (k + 1) % 3;
  const Eigen::Index v = (k + 2) % 3;
  const Eigen::Vector3f p = (point - origin_m_).cast<float>();
  const auto ku = static_cast<std::size_t>(u);
  const auto kv = static_cast<std::size_t>(v);
  const auto kk = static_cast<std::size_t>(k);
  std::array<std::uint32_t, kMaxWindingStack> waiting;
  std::size_t count = 0;
  waiting[count++] = 0;
  int sum = 0;
  while (count > 0) {
    const std::uint32_t next = waiting[--count];
    if ((next & BvhNode::kTriangle) == 0) {
      const BvhNode& node = nodes_[next];
      auto hit =
          (node.low[ku] <= p[u] && node.high[ku] >= p[u] && node.low[kv] <= p[v] && node.high[kv] >= p[v]).eval();
      if (forward) {
        hit = hit && node.high[kk] >= p[k];
      } else {
        hit = hit && node.low[kk] <= p[k];
      }
      for (std::size_t slot = 0; slot < 4; ++slot) {
        if (hit[static_cast<Eigen::Index>(slot)]) waiting[count++] = node.child[slot];
      }
      continue;
    }
    const TriangleCorners& t = corners_m_[next & ~BvhNode::kTriangle];
    const int around =
        crossing(t[0], t[1], point, u, v) + crossing(t[1], t[2], point, u, v) + crossing(t[2], t[0], point, u, v);
    if (around == 0) continue;
    const Vec3 a = t[0] - point;
    const Vec3 b = t[1] - point;
    const Vec3 c = t[2] - point;
    double ahead = 0;
    if (a[k] > 0 && b[k] > 0 && c[k] > 0) {
      ahead = 1;
    } else if (a[k] >= 0 || b[k] >= 0 || c[k] >= 0) {
      const Vec3 normal = (b - a).cross(c - a);
      ahead = normal[k] != 0 ? normal.dot(a) / normal[k] : a[k] + b[k] + c[k];
    } else {
      ahead = -1;
    }
    if (forward ? ahead > 0 : ahead < 0) sum += forward ? around : -around;
  }
  return sum;
}

double TriangleBvh::solid_angles(const Vec3& point, float dipole_from) const {
  const Eigen::Vector3f p = (point - origin_m_).cast<float>();
  const float from2 = dipole_from * dipole_from;
  std::array<std::uint32_t, kMaxWindingStack> waiting;
  std::size_t count = 0;
  waiting[count++] = 0;
  SolidAngles near;
  double dipoles = 0;
  while (count > 0) {
    const std::uint32_t next = waiting[--count];
    const BvhClusters& clusters = clusters_[next];
    BvhNode::Four distance2 = BvhNode::Four::Zero();
    BvhNode::Four along = BvhNode::Four::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const BvhNode::Four away = clusters.middle[axis] - p[static_cast<Eigen::Index>(axis)];
      distance2 += away * away;
      along += away * clusters.area_normal[axis];
    }
    const BvhNode::Four share = along / (distance2 * distance2.sqrt());
    for (std::size_t slot = 0; slot < 4; ++slot) {
      const auto at = static_cast<Eigen::Index>(slot);
      const std::uint32_t child = nodes_[next].child[slot];
      if (child == BvhNode::kNone) continue;
      if (distance2[at] > from2 * clusters.reach2[at]) {
        dipoles += static_cast<double>(share[at]);
      } else if ((child & BvhNode::kTriangle) != 0) {
        near.add(point, corners_m_[child & ~BvhNode::kTriangle]);
      } else {
        waiting[count++] = child;
      }
    }
  }
  return near.winding() + dipoles / (4 * std::numbers::pi);
}

double TriangleBvh::winding_number(const Vec3& point) const {
  if (nodes_.empty()) return 0;
  if (closed_) return crossings(point);
  const double winding = solid_angles(point, kDipoleFrom);
  return std::abs(std::abs(winding) - 0.5) < kUnsure ? solid_angles(point, kDipoleFromNearHalf) : winding;
}

bool TriangleBvh::inside(const Vec3& point) const {
  return solidity_ == Solidity::Solid && std::abs(winding_number(point)) > 0.5;
}

}  // namespace poise::geometry
