// SPDX-License-Identifier: MIT
#include "collision/triangles/triangle_pair.h"

#include <algorithm>
#include <cmath>

namespace poise::collision {
namespace {

// How far, as a sine, a direction may lean out of a cone of normals: rounding alone would drop a face that lies on an
// edge.
constexpr double kLean = 1e-7;
// The same for resting contact: faces that lie on each other may lean by this and still have their rims crossed.
// Chosen. kLeanOfBoth is twice the angle of it.
constexpr double kRestingLean = 0.1;
// Sine of the angle under which two edges count as parallel; their ends speak for them. Where the direction square to
// both is let lean it must not be rounding alone that it comes from.
constexpr double kParallel = 1e-6;
constexpr double kRestingParallel = 1e-4;
// Two points nearer than this share of their coordinates have no direction between them.
constexpr double kCoincidingPoints = 1e-13;
// More than rounding takes from a length.
constexpr double kRoundedUp = 1 + 1e-9;

using Side = PlacedTriangle::Side;

// The normal of the face beyond a side, zero where there is none.
Vec3 normal_beyond(const PlacedSurface& on, std::uint32_t beyond) {
  if (beyond == ShapeSurface::kNone) return Vec3::Zero();
  return on.rotation * on.surface->triangles[beyond].normal;
}

// Does a step from the side into either face not lead along `direction`?
bool in_cone(const Side& side, const Vec3& direction, double sine = kLean) {
  const double lean = sine * side.length_m;
  return side.into_m.dot(direction) <= lean && side.into_beyond_m.dot(direction) <= lean;
}

// The same at a corner, for each edge that leaves it.
bool in_cone(const PlacedSurface& on, std::uint32_t vertex, const Vec3& direction) {
  const Vec3 turned = on.rotation.transpose() * direction;
  const Vec3& at = on.surface->vertices_m[vertex];
  for (const std::uint32_t other : on.surface->neighbors_of(vertex)) {
    const Vec3 away = on.surface->vertices_m[other] - at;
    const double along = away.dot(turned);
    if (along > 0 && along * along > kLean * kLean * away.squaredNorm()) return false;
  }
  return true;
}

// Of a solid: does the direction leave it? Of any other surface both sides are outside.
bool leaves(const PlacedSurface& on, std::uint32_t vertex, const Vec3& direction) {
  if (!on.surface->solid) return true;
  return (on.rotation * on.surface->vertex_normal[vertex]).dot(direction) > 0;
}
bool leaves(const PlacedSurface& on, const Side& side, const Vec3& direction) {
  return !on.surface->solid || side.outward.dot(direction) > 0;
}

// Does the way from a point behind a surface to the surface come in through the far side of the solid? Then the point
// is not in it: the solid is thinner there. Sides that lean to the way are not far ones: at the rim of a face a corner
// may be a little outside of them.
bool passes_through(const PlacedSurface& on, const Vec3& from, const Vec3& to) {
  if (!on.surface->solid) return false;
  const auto in_body = [&](const Vec3& point) -> Vec3 { return on.rotation.transpose() * (point - on.offset_m); };
  return on.surface->bvh.enters_between(in_body(from), in_body(to));
}

// What the search for facing features writes to; swapped where b's features are looked at from b.
class Finder {
 public:
  Finder(const PlacedSurface& on_a, const PlacedTriangle& a, const PlacedSurface& on_b, const PlacedTriangle& b,
         const PlaneSides& sides, double reach_m, FeatureList& out, double beneath_m)
      : on_a_(on_a),
        a_(a),
        on_b_(on_b),
        b_(b),
        sides_(sides),
        reach_m_(reach_m),
        beneath_m_(beneath_m),
        farthest_m_(std::max(reach_m, beneath_m)),
        shallow_(reach_m > 0),
        near_a_(near_plane(a, sides.a_above_b, farthest_m_)),
        near_b_(near_plane(b, sides.b_above_a, farthest_m_)),
        out_(out) {}

  void corners_over_faces() {
    for (std::size_t k = 0; k < 3; ++k) {
      if (near_a_.corner[k]) corner_over_face(on_a_, a_, k, sides_.a_above_b[k], on_b_, b_, -1.0);
      if (near_b_.corner[k]) corner_over_face(on_b_, b_, k, sides_.b_above_a[k], on_a_, a_, 1.0);
    }
  }

  void edges() {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!near_a_.side[k]) continue;
      for (std::size_t m = 0; m < 3; ++m) {
        if (near_b_.side[m]) two_edges(k, m);
      }
    }
  }

  void corners_at_edges() {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t m = 0; m < 3; ++m) {
        if (near_a_.side[k] && near_b_.corner[m]) corner_at_edge(on_b_, b_, m, on_a_, a_, k, 1.0);
        if (near_a_.corner[k] && near_b_.side[m]) corner_at_edge(on_a_, a_, k, on_b_, b_, m, -1.0);
      }
    }
  }

  void corners() {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!near_a_.corner[k]) continue;
      for (std::size_t m = 0; m < 3; ++m) {
        if (near_b_.corner[m]) two_corners(k, m);
      }
    }
  }

  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  using Kind = FacingFeatures::Kind;

  // Corners and sides that a triangle stands for and that come within reach of the other's plane.
  struct Near {
    std::array<bool, 3> corner, side;
  };
  static Near near_plane(const PlacedTriangle& t, const std::array<double, 3>& above, double reach_m) {
    Near near;
    for (std::size_t k = 0; k < 3; ++k) {
      const double here = above[k];
      const double next = above[(k + 1) % 3];
      near.corner[k] = t.stands_for_vertex(k) && std::abs(here) <= reach_m;
      near.side[k] = t.stands_for_edge(k) && std::min(here, next) <= reach_m && std::max(here, next) >= -reach_m;
    }
    return near;
  }

  FacingFeatures& add(double gap_m, const Vec3& normal, const Vec3& point_a, const Vec3& point_b, Kind kind) {
    out_[count_] = {gap_m, normal, point_a, point_b, FacingFeatures::kNoCorner, kind, false, false, false};
    return out_[count_++];
  }

  // `sign` turns what leads from the face to the corner into what leads from a to b.
  void corner_over_face(const PlacedSurface& on_corner, const PlacedTriangle& corner, std::size_t k, double above_m,
                        const PlacedSurface& on_face, const PlacedTriangle& face, double sign) {
    const double height = std::abs(above_m);
    if (face.normal.isZero(0)) return;
    const bool solid = on_face.surface->solid;
    const Vec3& point = corner.corner_m[k];
    const std::uint32_t vertex = corner.vertex[k];
    const auto face_each_other = [&](const Vec3& to_corner, double gap_m, bool in_groove) {
      if (!leaves(on_corner, vertex, -to_corner)) return;
      const Vec3 on_plane = point - above_m * face.normal;
      const bool face_is_a = sign > 0;
      FacingFeatures& made =
          add(gap_m, sign * to_corner, face_is_a ? on_plane : point, face_is_a ? point : on_plane, Kind::CornerFace);
      made.corner = vertex;
      made.corner_of_b = face_is_a;
      made.resting = gap_m < 0;
      made.in_groove = in_groove;
    };
    const bool over = over_face(face, point);
    if (over && height <= reach_m_ && !(solid && above_m < 0)) {
      face_each_other(above_m < 0 ? Vec3(-face.normal) : face.normal, height, false);
    }
    if (height > beneath_m_ || above_m == 0) return;
    // The side that counts is the outer one; of a sheet, that of the other body.
    double side = 1;
    if (!solid) {
      if (!on_corner.surface->solid) return;
      if (face.normal.dot(on_corner.offset_m - face.corner_m[0]) < 0) side = -1;
    }
    if (side * above_m > 0 || !(over || past_groove(on_face, face, point, height, side))) return;
    if (shallow_ && passes_through(on_face, point, point - above_m * face.normal)) return;
    face_each_other(side * face.normal, -height, !over);
  }

  // Is a point that is `beneath_m` under a face past its rim only where the surface turns up, and no farther than it is
  // deep?
  static bool past_groove(const PlacedSurface& on, const PlacedTriangle& t, const Vec3& point_m, double beneath_m,
                          double up) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Side& side = t.side[k];
      const double past = -side.into_m.dot(point_m - t.corner_m[k]);
      if (past <= 0) continue;
      if (past > kPastRim * beneath_m * side.length_m) return false;
      const Vec3 into_beyond = side.along_m.cross(normal_beyond(on, on.surface->triangles[t.index].across[k]));
      if (!(up * t.normal.dot(into_beyond) > kLean * side.length_m)) return false;
    }
    return true;
  }

  // Interior points of both; the direction from the edges themselves, so that it stays true at no gap at all.
  void two_edges(std::size_t k, std::size_t m) {
    const Side& side_a = a_.side[k];
    const Side& side_b = b_.side[m];
    const double farthest = 0.5 * (side_a.length_m + side_b.length_m) * kRoundedUp + farthest_m_;
    if ((side_b.middle_m - side_a.middle_m).squaredNorm() > farthest * farthest) return;
    const Vec3 across = side_a.along_m.cross(side_b.along_m);
    const double across2 = across.squaredNorm();
    const double lengths = side_a.length_m * side_b.length_m;
    if (!(across2 > kParallel * kParallel * lengths * lengths)) return;
    const Vec3 between = b_.corner_m[m] - a_.corner_m[k];
    const double along_a = between.cross(side_b.along_m).dot(across);
    if (!(along_a > 0 && along_a < across2)) return;
    const double along_b = between.cross(side_a.along_m).dot(across);
    if (!(along_b > 0 && along_b < across2)) return;
    const Vec3 point_a = a_.corner_m[k] + along_a / across2 * side_a.along_m;
    const Vec3 point_b = b_.corner_m[m] + along_b / across2 * side_b.along_m;
    Vec3 normal = across / std::sqrt(across2);
    double gap = normal.dot(point_b - point_a);
    const bool turn = on_a_.surface->solid   ? normal.dot(side_a.outward) < 0
                      : on_b_.surface->solid ? normal.dot(side_b.outward) > 0
                                             : gap < 0;
    if (turn) {
      normal = -normal;
      gap = -gap;
    }
    if (gap < -beneath_m_ || gap > reach_m_ || !leaves(on_b_, side_b, -normal)) return;
    const bool touching = gap >= 0 && in_cone(side_a, normal) && in_cone(side_b, -normal);
    if (!touching) {
      if (beneath_m_ <= 0 || !(across2 > kRestingParallel * kRestingParallel * lengths * lengths)) return;
      if (!in_cone(side_a, normal, kRestingLean) || !in_cone(side_b, -normal, kRestingLean)) return;
      if (shallow_ && gap < 0 && (passes_through(on_b_, point_a, point_b) || passes_through(on_a_, point_b, point_a)))
        return;
    }
    add(gap, normal, point_a, point_b, Kind::Edges).resting = !touching;
  }

  void corner_at_edge(const PlacedSurface& on_corner, const PlacedTriangle& corner, std::size_t k,
                      const PlacedSurface& on_edge, const PlacedTriangle& edge, std::size_t m, double sign) {
    const Side& side = edge.side[m];
    const Vec3& point = corner.corner_m[k];
    const double share = (point - edge.corner_m[m]).dot(side.along_m);
    if (!(share > 0 && share < side.length_m * side.length_m)) return;
    const Vec3 at_edge = edge.corner_m[m] + share / (side.length_m * side.length_m) * side.along_m;
    const Vec3 between = point - at_edge;
    const double gap = between.norm();
    if (gap > reach_m_) return;
    const Vec3 to_corner = direction(between, gap, point, side.outward);
    const std::uint32_t vertex = corner.vertex[k];
    if (!leaves(on_edge, side, to_corner) || !leaves(on_corner, vertex, -to_corner)) return;
    if (!in_cone(side, to_corner) || !in_cone(on_corner, vertex, -to_corner)) return;
    const bool edge_is_a = sign > 0;
    add(gap, sign * to_corner, edge_is_a ? at_edge : point, edge_is_a ? point : at_edge, Kind::Other);
  }

  void two_corners(std::size_t k, std::size_t m) {
    const Vec3 between = b_.corner_m[m] - a_.corner_m[k];
    const double gap = between.norm();
    if (gap > reach_m_) return;
    const std::uint32_t vertex_a = a_.vertex[k];
    const std::uint32_t vertex_b = b_.vertex[m];
    const Vec3 normal =
        direction(between, gap, a_.corner_m[k], on_a_.rotation * on_a_.surface->vertex_normal[vertex_a]);
    if (!leaves(on_a_, vertex_a, normal) || !leaves(on_b_, vertex_b, -normal)) return;
    if (!in_cone(on_a_, vertex_a, normal) || !in_cone(on_b_, vertex_b, -normal)) return;
    add(gap, normal, a_.corner_m[k], b_.corner_m[m], Kind::Other);
  }

  static Vec3 direction(const Vec3& between, double length, const Vec3& near, const Vec3& otherwise) {
    if (length > kCoincidingPoints * near.cwiseAbs().maxCoeff()) return between / length;
    const double other = otherwise.norm();
    return other > 0 ? Vec3(otherwise / other) : Vec3(Vec3::UnitZ());
  }

  const PlacedSurface& on_a_;
  const PlacedTriangle& a_;
  const PlacedSurface& on_b_;
  const PlacedTriangle& b_;
  const PlaneSides& sides_;
  double reach_m_, beneath_m_, farthest_m_;
  bool shallow_;  // what overlaps deeply, and is looked for alone, may have passed through more than a wall
  Near near_a_, near_b_;
  FeatureList& out_;
  std::size_t count_ = 0;
};

// On which side of the line (p, q) the line (r, s) passes: the sign of the volume of the four points, zero counting as
// positive. Each line is run through from its lower vertex, so that both triangles at a side get the same number.
bool passes_left(const PlacedTriangle& a, std::size_t k, bool turn_a, const PlacedTriangle& b, std::size_t m,
                 bool turn_b) {
  const Vec3& p = a.corner_m[turn_a ? (k + 1) % 3 : k];
  const Vec3& q = a.corner_m[turn_a ? k : (k + 1) % 3];
  const Vec3& r = b.corner_m[turn_b ? (m + 1) % 3 : m];
  const Vec3& s = b.corner_m[turn_b ? m : (m + 1) % 3];
  const bool positive = (q - p).dot((r - p).cross(s - p)) >= 0;
  return positive != (turn_a != turn_b);
}

}  // namespace

void place(const PlacedSurface& placed, std::uint32_t triangle, PlacedTriangle& out) {
  place_with_features(placed, triangle, placed.surface->triangles[triangle].features, out);
}

void place_with_features(const PlacedSurface& placed, std::uint32_t triangle, std::uint8_t features,
                         PlacedTriangle& out) {
  const ShapeSurface::Triangle& t = placed.surface->triangles[triangle];
  for (std::size_t k = 0; k < 3; ++k) out.corner_m[k] = placed.point(placed.surface->vertices_m[t.vertex[k]]);
  out.normal = placed.rotation * t.normal;
  out.index = triangle;
  out.vertex = t.vertex;
  out.features = features;
  for (std::size_t k = 0; k < 3; ++k) {
    PlacedTriangle::Side& side = out.side[k];
    side.along_m = out.corner_m[(k + 1) % 3] - out.corner_m[k];
    side.middle_m = 0.5 * (out.corner_m[k] + out.corner_m[(k + 1) % 3]);
    side.into_m = out.normal.cross(side.along_m);
    side.length_m = side.along_m.norm();
    if (!out.stands_for_edge(k)) continue;
    const Vec3 beyond = normal_beyond(placed, t.across[k]);
    side.into_beyond_m = side.along_m.cross(beyond);
    side.outward = out.normal + beyond;
  }
}

bool over_face(const PlacedTriangle& t, const Vec3& point_m) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (t.side[k].into_m.dot(point_m - t.corner_m[k]) < 0) return false;
  }
  return true;
}

PlaneSides plane_sides(const PlacedTriangle& a, const PlacedTriangle& b) {
  PlaneSides sides;
  for (std::size_t k = 0; k < 3; ++k) {
    sides.a_above_b[k] = b.normal.dot(a.corner_m[k] - b.corner_m[0]);
    sides.b_above_a[k] = a.normal.dot(b.corner_m[k] - a.corner_m[0]);
  }
  return sides;
}

bool beyond(const PlaneSides& sides, double reach_m) {
  const auto apart = [reach_m](const std::array<double, 3>& above) {
    return (above[0] > reach_m && above[1] > reach_m && above[2] > reach_m) ||
           (above[0] < -reach_m && above[1] < -reach_m && above[2] < -reach_m);
  };
  return apart(sides.a_above_b) || apart(sides.b_above_a);
}

std::optional<CrossingSegment> crossing(const PlacedTriangle& a, const PlacedTriangle& b, const PlaneSides& sides) {
  const auto split = [](const std::array<double, 3>& above) {
    const int over = (above[0] >= 0 ? 1 : 0) + (above[1] >= 0 ? 1 : 0) + (above[2] >= 0 ? 1 : 0);
    return over == 1 || over == 2;
  };
  if (!split(sides.a_above_b) || !split(sides.b_above_a)) return std::nullopt;
  std::array<bool, 3> turn_a;
  std::array<bool, 3> turn_b;
  for (std::size_t k = 0; k < 3; ++k) {
    turn_a[k] = a.vertex[k] > a.vertex[(k + 1) % 3];
    turn_b[k] = b.vertex[k] > b.vertex[(k + 1) % 3];
  }
  // Each of the nine is asked once, and only where a side passes the other's plane.
  enum class Left : std::uint8_t { Unknown, No, Yes };
  std::array<std::array<Left, 3>, 3> known{};
  const auto left = [&](std::size_t k, std::size_t m) {
    Left& answer = known[k][m];
    if (answer == Left::Unknown) answer = passes_left(a, k, turn_a[k], b, m, turn_b[m]) ? Left::Yes : Left::No;
    return answer;
  };
  const auto passes_plane = [](const std::array<double, 3>& above, std::size_t k) {
    return (above[k] >= 0) != (above[(k + 1) % 3] >= 0);
  };
  std::array<Vec3, 6> ends;
  std::size_t count = 0;
  const auto pierce = [&](const PlacedTriangle& t, std::size_t k, bool turn, const std::array<double, 3>& above) {
    const std::size_t from = turn ? (k + 1) % 3 : k;
    const std::size_t to = turn ? k : (k + 1) % 3;
    const double share = above[from] / (above[from] - above[to]);
    ends[count++] = t.corner_m[from] + std::clamp(share, 0.0, 1.0) * (t.corner_m[to] - t.corner_m[from]);
  };
  for (std::size_t k = 0; k < 3; ++k) {
    if (passes_plane(sides.a_above_b, k) && left(k, 0) == left(k, 1) && left(k, 1) == left(k, 2))
      pierce(a, k, turn_a[k], sides.a_above_b);
    if (passes_plane(sides.b_above_a, k) && left(0, k) == left(1, k) && left(1, k) == left(2, k))
      pierce(b, k, turn_b[k], sides.b_above_a);
  }
  if (count < 2) return std::nullopt;
  // More than two ends come from rounding alone; the two farthest apart stand for them.
  CrossingSegment segment{ends[0], ends[1]};
  double longest2 = (ends[1] - ends[0]).squaredNorm();
  for (std::size_t i = 0; i + 1 < count; ++i) {
    for (std::size_t j = std::max<std::size_t>(i + 1, 2); j < count; ++j) {
      const double length2 = (ends[j] - ends[i]).squaredNorm();
      if (length2 <= longest2) continue;
      longest2 = length2;
      segment = {ends[i], ends[j]};
    }
  }
  if (a.normal.cross(b.normal).dot(segment.to_m - segment.from_m) < 0) std::swap(segment.from_m, segment.to_m);
  return segment;
}

std::size_t facing_features(const PlacedSurface& on_a, const PlacedTriangle& a, const PlacedSurface& on_b,
                            const PlacedTriangle& b, const PlaneSides& sides, double reach_m, FeatureList& out,
                            double beneath_m) {
  Finder finder(on_a, a, on_b, b, sides, reach_m, out, beneath_m);
  finder.corners_over_faces();
  finder.edges();
  // A corner is never nearer than 0 to an edge or a corner.
  if (reach_m > 0) {
    finder.corners_at_edges();
    finder.corners();
  }
  return finder.count();
}

std::size_t features_facing_point(const PlacedSurface& on_a, const PlacedTriangle& a, const Vec3& point_m,
                                  double reach_m, FeatureList& out) {
  std::size_t count = 0;
  const auto add = [&](double gap, const Vec3& normal, const Vec3& at) {
    out[count++] = {gap,   normal, at,   point_m, FacingFeatures::kNoCorner, FacingFeatures::Kind::Other,
                    false, false,  false};
  };
  const double above = a.normal.dot(point_m - a.corner_m[0]);
  if (!a.normal.isZero(0) && std::abs(above) <= reach_m && !(on_a.surface->solid && above < 0) &&
      over_face(a, point_m)) {
    add(std::abs(above), above < 0 ? Vec3(-a.normal) : a.normal, point_m - above * a.normal);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const auto faced = [&](const Vec3& at, auto&& within) {
      const Vec3 between = point_m - at;
      const double gap = between.norm();
      if (gap > reach_m || !(gap > kCoincidingPoints * at.cwiseAbs().maxCoeff())) return;
      const Vec3 normal = between / gap;
      if (within(normal)) add(gap, normal, at);
    };
    if (a.stands_for_vertex(k)) {
      faced(a.corner_m[k], [&](const Vec3& normal) { return in_cone(on_a, a.vertex[k], normal); });
    }
    if (!a.stands_for_edge(k)) continue;
    const Side& side = a.side[k];
    const double share = (point_m - a.corner_m[k]).dot(side.along_m) / (side.length_m * side.length_m);
    if (!(share > 0 && share < 1)) continue;
    faced(a.corner_m[k] + share * side.along_m, [&](const Vec3& normal) { return in_cone(side, normal); });
  }
  return count;
}

}  // namespace poise::collision
