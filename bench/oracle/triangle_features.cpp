// SPDX-License-Identifier: MIT
#include "oracle/triangle_features.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace poise::oracle {
namespace {

struct Plane {
  Vec3 normal;  // unit
  Vec3 origin_m;
};

std::optional<Plane> plane_of(const TrianglePoints& t) {
  const Vec3 across = (t[1] - t[0]).cross(t[2] - t[0]);
  const double length = across.norm();
  if (!(length > 0)) return std::nullopt;
  return Plane{across / length, t[0]};
}

// Whether a point of the triangle's plane is within its three sides, borders included.
bool within(const TrianglePoints& t, const Vec3& normal, const Vec3& point_m) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& from = t[i];
    if (normal.dot((t[(i + 1) % 3] - from).cross(point_m - from)) < 0) return false;
  }
  return true;
}

struct Crossing {
  double share_a = 0, share_b = 0;  // of the way along each edge, in [0, 1]
  [[nodiscard]] bool inside() const { return share_a > 0 && share_a < 1 && share_b > 0 && share_b < 1; }
};

// Nearest points of two segments: first of the lines; then each point beyond an end is clamped, and the other point is
// computed again.
Crossing nearest_on_segments(const Vec3& from_a, const Vec3& along_a, const Vec3& from_b, const Vec3& along_b) {
  const Vec3 between = from_b - from_a;
  const double aa = along_a.squaredNorm();
  const double bb = along_b.squaredNorm();
  const double ab = along_a.dot(along_b);
  const double a_between = along_a.dot(between);
  const double b_between = along_b.dot(between);
  const auto clamped = [](double share) { return std::clamp(share, 0.0, 1.0); };
  Crossing at;
  const double slant = aa * bb - ab * ab;
  if (slant > 1e-14 * aa * bb) at.share_a = clamped((a_between * bb - b_between * ab) / slant);
  const double free_b = bb > 0 ? (at.share_a * ab - b_between) / bb : 0;
  at.share_b = clamped(free_b);
  if (at.share_b != free_b && aa > 0) at.share_a = clamped((a_between + at.share_b * ab) / aa);
  return at;
}

// A vertex counts if its foot lies within the face; otherwise the edges are nearer.
void look_at_vertex(const Vec3& vertex_m, const TrianglePoints& face, const Plane& plane, bool vertex_of_a,
                    NearestFeatures& best) {
  const double height = plane.normal.dot(vertex_m - plane.origin_m);
  if (std::abs(height) >= best.distance_m) return;
  const Vec3 foot = vertex_m - height * plane.normal;
  if (!within(face, plane.normal, foot)) return;
  best.distance_m = std::abs(height);
  best.on_a_m = vertex_of_a ? vertex_m : foot;
  best.on_b_m = vertex_of_a ? foot : vertex_m;
  // From a to b: away from the vertex if it is a's, toward it if it is b's.
  best.normal = (vertex_of_a == (height > 0)) ? Vec3(-plane.normal) : plane.normal;
  best.feature = vertex_of_a ? Feature::VertexFace : Feature::FaceVertex;
}

void look_at_edges(const Vec3& from_a, const Vec3& to_a, const Vec3& from_b, const Vec3& to_b, NearestFeatures& best) {
  const Vec3 along_a = to_a - from_a;
  const Vec3 along_b = to_b - from_b;
  const Crossing at = nearest_on_segments(from_a, along_a, from_b, along_b);
  const Vec3 on_a = from_a + at.share_a * along_a;
  const Vec3 on_b = from_b + at.share_b * along_b;
  const Vec3 between = on_b - on_a;
  const double distance = between.norm();
  if (distance >= best.distance_m) return;
  best = {distance, on_a, on_b, distance > 0 ? Vec3(between / distance) : Vec3::Zero(), Feature::Other};
  if (!at.inside()) return;
  best.feature = Feature::EdgeEdge;
  const Vec3 across = along_a.cross(along_b);
  const double length = across.norm();
  if (length > 1e-7 * along_a.norm() * along_b.norm())
    best.normal = (across.dot(between) < 0 ? -1.0 : 1.0) / length * across;
}

// Whether an edge of one triangle passes through the face of the other.
bool pierces(const TrianglePoints& edges_of, const TrianglePoints& face, const Plane& plane, Vec3& point_m) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& from = edges_of[i];
    const Vec3& to = edges_of[(i + 1) % 3];
    const double height_from = plane.normal.dot(from - plane.origin_m);
    const double height_to = plane.normal.dot(to - plane.origin_m);
    if ((height_from > 0) == (height_to > 0) || height_from == height_to) continue;
    point_m = from + height_from / (height_from - height_to) * (to - from);
    if (within(face, plane.normal, point_m)) return true;
  }
  return false;
}

}  // namespace

NearestFeatures nearest_features(const TrianglePoints& a, const TrianglePoints& b) {
  const std::optional<Plane> plane_a = plane_of(a);
  const std::optional<Plane> plane_b = plane_of(b);
  NearestFeatures best;
  Vec3 point_m;
  if ((plane_b && pierces(a, b, *plane_b, point_m)) || (plane_a && pierces(b, a, *plane_a, point_m))) {
    best.on_a_m = best.on_b_m = point_m;
    return best;
  }
  best.distance_m = HUGE_VAL;
  for (const Vec3& vertex : a) {
    if (plane_b) look_at_vertex(vertex, b, *plane_b, true, best);
  }
  for (const Vec3& vertex : b) {
    if (plane_a) look_at_vertex(vertex, a, *plane_a, false, best);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) look_at_edges(a[i], a[(i + 1) % 3], b[k], b[(k + 1) % 3], best);
  }
  return best;
}

}  // namespace poise::oracle
