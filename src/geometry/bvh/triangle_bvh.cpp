// SPDX-License-Identifier: MIT
#include "geometry/bvh/triangle_bvh.h"

#include <algorithm>
#include <cmath>

#include "geometry/bvh/triangle_bvh_build.h"

namespace poise::geometry {
namespace {

/// Most nodes on the stack of a search: three a level of at most 63 levels of four children each.
constexpr std::size_t kMostWaiting = 256;
/// Squared distances to boxes are computed in single precision; a bound is widened by more than their error.
constexpr double kQueryWiden = 1 + 1e-5;
// Of ways that pass a surface: the share at each end that does not count, the cosine of the largest angle to the
// normal, and by how much of its size a triangle is wider.
constexpr double kEndOfWay = 1e-3;
constexpr double kAcross = 0.9;
constexpr double kPastSide = 1e-9;

Vec3 closest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length2 = along.squaredNorm();
  if (!(length2 > 0)) return a;
  return a + std::clamp((p - a).dot(along) / length2, 0.0, 1.0) * along;
}

Vec3 closest_on_edges(const Vec3& p, const TriangleCorners& t) {
  Vec3 best = closest_on_segment(p, t[0], t[1]);
  for (std::size_t i = 1; i < 3; ++i) {
    const Vec3 candidate = closest_on_segment(p, t[i], t[(i + 1) % 3]);
    if ((candidate - p).squaredNorm() < (best - p).squaredNorm()) best = candidate;
  }
  return best;
}

/// Squared distances from a point to each of a node's boxes, in the frame of the boxes; infinite for no child.
BvhNode::Four squared_distances(const BvhNode& node, const Eigen::Vector3f& p) {
  BvhNode::Four sum = BvhNode::Four::Zero();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float x = p[static_cast<Eigen::Index>(axis)];
    const BvhNode::Four beyond = (node.low[axis] - x).max(x - node.high[axis]).max(0.0F);
    sum += beyond * beyond;
  }
  return sum;
}

}  // namespace

Vec3 closest_on_triangle(const Vec3& p, const TriangleCorners& t) {
  const Vec3 ab = t[1] - t[0];
  const Vec3 ac = t[2] - t[0];
  const Vec3 ap = p - t[0];
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return t[0];
  const Vec3 bp = p - t[1];
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return t[1];
  const Vec3 cp = p - t[2];
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return t[2];
  const double vc = d1 * d4 - d3 * d2;
  const double vb = d5 * d2 - d1 * d6;
  const double va = d3 * d6 - d5 * d4;
  const double sum = va + vb + vc;  // the squared length of ab x ac
  if (!(sum > 1e-20 * ab.squaredNorm() * ac.squaredNorm())) return closest_on_edges(p, t);
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return t[0] + d1 / (d1 - d3) * ab;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return t[0] + d2 / (d2 - d6) * ac;
  const double along = d4 - d3;
  const double back = d5 - d6;
  if (va <= 0 && along >= 0 && back >= 0) return t[1] + along / (along + back) * (t[2] - t[1]);
  return t[0] + vb / sum * ab + vc / sum * ac;
}

TriangleBvh::TriangleBvh(const TriangleMesh& mesh, Solidity solidity)
    : solidity_(solidity), closed_(check_closed(mesh).closed()) {
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t) box_.add(mesh.vertices_m[v]);
  }
  const std::size_t count = mesh.triangles.size();
  if (count == 0) return;
  origin_m_ = box_.center();
  BvhLayout layout = flatten_bvh(mesh, box_);
  triangle_of_ = std::move(layout.order);
  position_.resize(count);
  corners_m_.reserve(count);
  for (std::uint32_t place = 0; place < count; ++place) {
    position_[triangle_of_[place]] = place;
    const auto& t = mesh.triangles[triangle_of_[place]];
    corners_m_.push_back({mesh.vertices_m[t[0]], mesh.vertices_m[t[1]], mesh.vertices_m[t[2]]});
  }
  nodes_ = std::move(layout.nodes);
  if (!closed_) clusters_ = clusters_of(nodes_, corners_m_, origin_m_);
}

TriangleBvh::Closest TriangleBvh::closest(const Vec3& point, double squared_bound_m2) const {
  Closest best;
  best.squared_distance_m2 = squared_bound_m2;
  search(point, best);
  return best;
}

TriangleBvh::Closest TriangleBvh::closest_from(const Vec3& point, std::uint32_t guess) const {
  Closest best;
  if (guess < position_.size()) {
    best.point_m = closest_on_triangle(point, corners(guess));
    best.squared_distance_m2 = (best.point_m - point).squaredNorm();
    best.triangle = guess;
  }
  search(point, best);
  return best;
}

void TriangleBvh::search(const Vec3& point, Closest& best) const {
  if (nodes_.empty()) return;
  struct Waiting {
    float least2;
    std::uint32_t child;
  };
  std::array<Waiting, kMostWaiting> waiting;
  std::size_t count = 0;
  const Eigen::Vector3f p = (point - origin_m_).cast<float>();
  auto limit2 = static_cast<float>(best.squared_distance_m2 * kQueryWiden);
  std::uint32_t next = 0;
  for (;;) {
    if ((next & BvhNode::kTriangle) != 0) {
      const std::uint32_t place = next & ~BvhNode::kTriangle;
      const Vec3 candidate = closest_on_triangle(point, corners_m_[place]);
      const double d2 = (candidate - point).squaredNorm();
      if (d2 < best.squared_distance_m2) {
        best = {d2, candidate, triangle_of_[place]};
        limit2 = static_cast<float>(d2 * kQueryWiden);
      }
    } else {
      const BvhNode& node = nodes_[next];
      const BvhNode::Four least2 = squared_distances(node, p);
      // The nearest child is on top of the stack.
      const std::size_t base = count;
      for (std::size_t slot = 0; slot < 4; ++slot) {
        const float slot2 = least2[static_cast<Eigen::Index>(slot)];
        if (!(slot2 < limit2)) continue;
        std::size_t at = count++;
        for (; at > base && waiting[at - 1].least2 < slot2; --at) waiting[at] = waiting[at - 1];
        waiting[at] = {slot2, node.child[slot]};
      }
    }
    do {
      if (count == 0) return;
      --count;
    } while (!(waiting[count].least2 < limit2));
    next = waiting[count].child;
  }
}

template <class Visit>
bool TriangleBvh::any_near(const Vec3& point, double radius_m, Visit&& visit) const {
  if (nodes_.empty()) return false;
  std::array<std::uint32_t, kMostWaiting> waiting;
  std::size_t count = 0;
  const Eigen::Vector3f p = (point - origin_m_).cast<float>();
  const auto limit2 = static_cast<float>(radius_m * radius_m * kQueryWiden);
  waiting[count++] = 0;
  while (count > 0) {
    const BvhNode& node = nodes_[waiting[--count]];
    const BvhNode::Four least2 = squared_distances(node, p);
    for (std::size_t slot = 0; slot < 4; ++slot) {
      const std::uint32_t child = node.child[slot];
      if (child == BvhNode::kNone || !(least2[static_cast<Eigen::Index>(slot)] <= limit2)) continue;
      if ((child & BvhNode::kTriangle) == 0) {
        waiting[count++] = child;
      } else if (visit(child & ~BvhNode::kTriangle)) {
        return true;
      }
    }
  }
  return false;
}

void TriangleBvh::triangles_near(const Vec3& point, double radius_m, std::vector<std::uint32_t>& out) const {
  any_near(point, radius_m, [&](std::uint32_t place) {
    out.push_back(triangle_of_[place]);
    return false;
  });
}

bool TriangleBvh::enters_between(const Vec3& from, const Vec3& to) const {
  const Vec3 way = to - from;
  const double length = way.norm();
  return any_near(from + 0.5 * way, 0.5 * length, [&](std::uint32_t place) {
    const TriangleCorners& t = corners_m_[place];
    const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
    const double size = normal.norm();
    const double falls = normal.dot(way);
    if (!(falls < -kAcross * size * length)) return false;
    const double share = normal.dot(t[0] - from) / falls;
    if (share < kEndOfWay || share > 1 - kEndOfWay) return false;
    const Vec3 at = from + share * way;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 side = t[(k + 1) % 3] - t[k];
      if (normal.dot(side.cross(at - t[k])) < -kPastSide * size * size) return false;
    }
    return true;
  });
}

Vec3 TriangleBvh::triangle_normal(std::uint32_t triangle) const {
  const TriangleCorners& t = corners(triangle);
  const Vec3 across = (t[1] - t[0]).cross(t[2] - t[0]);
  const double length = across.norm();
  return length > 0 ? Vec3(across / length) : Vec3::Zero();
}

double TriangleBvh::outside_distance_m(const Vec3& point) const {
  return inside(point) ? 0.0 : std::sqrt(closest(point).squared_distance_m2);
}

double TriangleBvh::signed_distance_m(const Vec3& point) const {
  const double distance_m = std::sqrt(closest(point).squared_distance_m2);
  return inside(point) ? -distance_m : distance_m;
}

}  // namespace poise::geometry
