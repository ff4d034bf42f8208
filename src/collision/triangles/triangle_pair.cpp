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
// Chosen.
constexpr double kRestingLean = 0.1;
// Twice the angle of that sine, and more than rounding.
constexpr double kLeanOfBoth = 0.2004;
// Sine of the angle under which two edges count as parallel; their ends speak for them. Where the direction square to
// both is let lean it must not be rounding alone that it comes from.
constexpr double kParallel = 1e-6;
constexpr double kRestingParallel = 1e-4;
// In a groove a corner beneath one face may be so many times its depth past the rim.
constexpr double kPastRim = 2;
// Two points nearer than this share of their coordinates have no direction between them.
constexpr double kCoincidingPoints = 1e-13;

// A side of a triangle with what lies on its other side.
struct Side {
  Vec3 from_m, along;
  Vec3 into, into_beyond;  // in each face, square to the side, away from it; zero where there is no second face
  Vec3 outward;            // sum of the normals
  double length_m;
};

Side side_of(const PlacedSurface& on, const PlacedTriangle& t, std::size_t k) {
  Side side;
  side.from_m = t.corner_m[k];
  side.along = t.along_m[k];
  side.length_m = t.length_m[k];
  side.into = t.into_m[k];
  side.into_beyond.setZero();
  side.outward = t.normal;
  const std::uint32_t beyond = on.surface->triangles[t.index].across[k];
  if (beyond != ShapeSurface::kNone) {
    const Vec3 normal = on.rotation * on.surface->triangles[beyond].normal;
    side.into_beyond = side.along.cross(normal);
    side.outward += normal;
  }
  return side;
}

// Does a step from the side into either face not lead along `direction`?
bool in_cone(const Side& side, const Vec3& direction, double sine = kLean) {
  const double lean = sine * side.length_m;
  return side.into.dot(direction) <= lean && side.into_beyond.dot(direction) <= lean;
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

std::uint32_t vertex_of(const PlacedSurface& on, const PlacedTriangle& t, std::size_t k) {
  return on.surface->triangles[t.index].vertex[k];
}

// Of two triangles, what can face each other at all. A corner lies over a face where it is no farther from the face's
// axis than both triangles are wide, or a little past its rim in a groove. Two sides or corners face each other along a
// direction in the cones of both; from a's axis they are as far as that direction leans beside the gap. Bounds: cos x
// >= 1 - x^2 / 2, sin x <= x.
struct Facing {
  bool corners_and_faces, cones;
  Facing(const PlacedTriangle& a, const PlacedTriangle& b, double most_gap_m, double past_rim_m) {
    const Vec3 between = b.center_m - a.center_m;
    const double length2 = between.squaredNorm();
    const double wide_m = (a.radius_m + b.radius_m) * (1 + 1e-6);
    const auto aside2 = [&](const PlacedTriangle& t) {
      const double along = t.normal.dot(between);
      return length2 - along * along;
    };
    const double aside2_a = aside2(a);
    const double over_m = wide_m + past_rim_m;
    corners_and_faces = aside2_a <= over_m * over_m || aside2(b) <= over_m * over_m;
    const double lean = static_cast<double>(a.spread_rad) + 0.5 * kLeanOfBoth;
    const double angle = static_cast<double>(b.spread_rad) + 0.5 * kLeanOfBoth + lean;
    const double leaning_m = wide_m + lean * most_gap_m;
    cones = -a.normal.dot(b.normal) >= 1 - 0.5 * angle * angle && aside2_a <= leaning_m * leaning_m;
  }
};

// What the search for facing features writes to; swapped where b's features are looked at from b.
class Finder {
 public:
  Finder(const PlacedSurface& on_a, const PlacedTriangle& a, const PlacedSurface& on_b, const PlacedTriangle& b,
         double reach_m, FeatureList& out, double beneath_m)
      : on_a_(on_a), a_(a), on_b_(on_b), b_(b), reach_m_(reach_m), beneath_m_(beneath_m), out_(out) {}

  void corners_over_faces(const PlaneSides& sides) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (a_.stands_for_vertex(k)) corner_over_face(on_a_, a_, k, sides.a_above_b[k], on_b_, b_, -1.0);
      if (b_.stands_for_vertex(k)) corner_over_face(on_b_, b_, k, sides.b_above_a[k], on_a_, a_, 1.0);
    }
  }

  void edges() {
    std::array<Side, 3> sides_b;
    for (std::size_t m = 0; m < 3; ++m) {
      if (b_.stands_for_edge(m)) sides_b[m] = side_of(on_b_, b_, m);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (a_.stands_for_edge(k)) {
        const Side side_a = side_of(on_a_, a_, k);
        for (std::size_t m = 0; m < 3; ++m) {
          if (b_.stands_for_edge(m)) two_edges(side_a, sides_b[m]);
          if (b_.stands_for_vertex(m)) corner_at_edge(on_b_, b_, m, on_a_, side_a, 1.0);
        }
      }
      for (std::size_t m = 0; m < 3; ++m) {
        if (a_.stands_for_vertex(k) && b_.stands_for_edge(m)) corner_at_edge(on_a_, a_, k, on_b_, sides_b[m], -1.0);
      }
    }
  }

  void corners() {
    for (std::size_t k = 0; k < 3; ++k) {
      if (!a_.stands_for_vertex(k)) continue;
      for (std::size_t m = 0; m < 3; ++m) {
        if (b_.stands_for_vertex(m)) two_corners(k, m);
      }
    }
  }

  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  using Kind = FacingFeatures::Kind;

  FacingFeatures& add(double gap_m, const Vec3& normal, const Vec3& point_a, const Vec3& point_b, Kind kind) {
    out_[count_] = {gap_m, normal, point_a, point_b, FacingFeatures::kNoCorner, kind, false, false, false};
    return out_[count_++];
  }

  // `sign` turns what leads from the face to the corner into what leads from a to b.
  void corner_over_face(const PlacedSurface& on_corner, const PlacedTriangle& corner, std::size_t k, double above_m,
                        const PlacedSurface& on_face, const PlacedTriangle& face, double sign) {
    const double height = std::abs(above_m);
    if (height > std::max(reach_m_, beneath_m_) || face.normal.isZero(0)) return;
    const bool solid = on_face.surface->solid;
    const Vec3& point = corner.corner_m[k];
    const std::uint32_t vertex = vertex_of(on_corner, corner, k);
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
    face_each_other(side * face.normal, -height, !over);
  }

  // Is a point that is `beneath_m` under a face past its rim only where the surface turns up, and no farther than it is
  // deep?
  static bool past_groove(const PlacedSurface& on, const PlacedTriangle& t, const Vec3& point_m, double beneath_m,
                          double up) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Side side = side_of(on, t, k);
      const double past = -side.into.dot(point_m - side.from_m);
      if (past <= 0) continue;
      if (past > kPastRim * beneath_m * side.length_m || !(up * t.normal.dot(side.into_beyond) > kLean * side.length_m))
        return false;
    }
    return true;
  }

  // Interior points of both; the direction from the edges themselves, so that it stays true at no gap at all.
  void two_edges(const Side& side_a, const Side& side_b) {
    const Vec3 across = side_a.along.cross(side_b.along);
    const double across2 = across.squaredNorm();
    const double lengths = side_a.length_m * side_b.length_m;
    if (!(across2 > kParallel * kParallel * lengths * lengths)) return;
    const Vec3 between = side_b.from_m - side_a.from_m;
    const double s = between.cross(side_b.along).dot(across) / across2;
    const double t = between.cross(side_a.along).dot(across) / across2;
    if (!(s > 0 && s < 1 && t > 0 && t < 1)) return;
    const Vec3 point_a = side_a.from_m + s * side_a.along;
    const Vec3 point_b = side_b.from_m + t * side_b.along;
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
    }
    add(gap, normal, point_a, point_b, Kind::Edges).resting = !touching;
  }

  void corner_at_edge(const PlacedSurface& on_corner, const PlacedTriangle& corner, std::size_t k,
                      const PlacedSurface& on_edge, const Side& side, double sign) {
    const Vec3& point = corner.corner_m[k];
    const double share = (point - side.from_m).dot(side.along);
    if (!(share > 0 && share < side.length_m * side.length_m)) return;
    const Vec3 at_edge = side.from_m + share / (side.length_m * side.length_m) * side.along;
    const Vec3 between = point - at_edge;
    const double gap = between.norm();
    if (gap > reach_m_) return;
    const Vec3 to_corner = direction(between, gap, point, side.outward);
    const std::uint32_t vertex = vertex_of(on_corner, corner, k);
    if (!leaves(on_edge, side, to_corner) || !leaves(on_corner, vertex, -to_corner)) return;
    if (!in_cone(side, to_corner) || !in_cone(on_corner, vertex, -to_corner)) return;
    const bool edge_is_a = sign > 0;
    add(gap, sign * to_corner, edge_is_a ? at_edge : point, edge_is_a ? point : at_edge, Kind::Other);
  }

  void two_corners(std::size_t k, std::size_t m) {
    const Vec3 between = b_.corner_m[m] - a_.corner_m[k];
    const double gap = between.norm();
    if (gap > reach_m_) return;
    const std::uint32_t vertex_a = vertex_of(on_a_, a_, k);
    const std::uint32_t vertex_b = vertex_of(on_b_, b_, m);
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
  double reach_m_, beneath_m_;
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
  const ShapeSurface::Triangle& t = placed.surface->triangles[triangle];
  for (std::size_t k = 0; k < 3; ++k) out.corner_m[k] = placed.point(placed.surface->vertices_m[t.vertex[k]]);
  out.normal = placed.rotation * t.normal;
  for (std::size_t k = 0; k < 3; ++k) {
    out.along_m[k] = out.corner_m[(k + 1) % 3] - out.corner_m[k];
    out.into_m[k] = out.normal.cross(out.along_m[k]);
    out.length_m[k] = out.along_m[k].norm();
  }
  out.center_m = placed.point(t.center_m);
  out.radius_m = t.radius_m;
  out.index = triangle;
  out.features = t.features;
  out.spread_rad = t.spread_rad;
}

bool over_face(const PlacedTriangle& t, const Vec3& point_m) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (t.into_m[k].dot(point_m - t.corner_m[k]) < 0) return false;
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

bool beside(const PlacedTriangle& a, const PlacedTriangle& b, double reach_m) {
  const auto past_a_side = [reach_m](const PlacedTriangle& t, const PlacedTriangle& other) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double least = -reach_m * t.length_m[k];
      const auto past = [&](const Vec3& corner) { return t.into_m[k].dot(corner - t.corner_m[k]) < least; };
      if (past(other.corner_m[0]) && past(other.corner_m[1]) && past(other.corner_m[2])) return true;
    }
    return false;
  };
  return past_a_side(a, b) || past_a_side(b, a);
}

double past_rim_m(const PlacedSurface& on_a, const PlacedSurface& on_b, const PlaneSides& sides, double beneath_m) {
  double deepest_m = 0;
  const auto look = [&](bool solid, const std::array<double, 3>& above) {
    for (const double height : above) {
      const double depth_m = solid ? -height : std::abs(height);
      if (depth_m <= beneath_m) deepest_m = std::max(deepest_m, depth_m);
    }
  };
  look(on_b.surface->solid, sides.a_above_b);
  look(on_a.surface->solid, sides.b_above_a);
  return kPastRim * deepest_m;
}

std::optional<CrossingSegment> crossing(const PlacedSurface& on_a, const PlacedTriangle& a, const PlacedSurface& on_b,
                                        const PlacedTriangle& b, const PlaneSides& sides) {
  const auto split = [](const std::array<double, 3>& above) {
    const int over = (above[0] >= 0 ? 1 : 0) + (above[1] >= 0 ? 1 : 0) + (above[2] >= 0 ? 1 : 0);
    return over == 1 || over == 2;
  };
  if (!split(sides.a_above_b) || !split(sides.b_above_a)) return std::nullopt;
  std::array<bool, 3> turn_a;
  std::array<bool, 3> turn_b;
  for (std::size_t k = 0; k < 3; ++k) {
    turn_a[k] = vertex_of(on_a, a, k) > vertex_of(on_a, a, (k + 1) % 3);
    turn_b[k] = vertex_of(on_b, b, k) > vertex_of(on_b, b, (k + 1) % 3);
  }
  std::array<std::array<bool, 3>, 3> left;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t m = 0; m < 3; ++m) left[k][m] = passes_left(a, k, turn_a[k], b, m, turn_b[m]);
  }
  std::array<Vec3, 6> ends;
  std::size_t count = 0;
  const auto pierce = [&](const PlacedTriangle& t, std::size_t k, bool turn, const std::array<double, 3>& above) {
    const std::size_t from = turn ? (k + 1) % 3 : k;
    const std::size_t to = turn ? k : (k + 1) % 3;
    const double share = above[from] / (above[from] - above[to]);
    ends[count++] = t.corner_m[from] + std::clamp(share, 0.0, 1.0) * (t.corner_m[to] - t.corner_m[from]);
  };
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const bool through_a = left[k][0] == left[k][1] && left[k][1] == left[k][2];
    if (through_a && (sides.a_above_b[k] >= 0) != (sides.a_above_b[next] >= 0))
      pierce(a, k, turn_a[k], sides.a_above_b);
    const bool through_b = left[0][k] == left[1][k] && left[1][k] == left[2][k];
    if (through_b && (sides.b_above_a[k] >= 0) != (sides.b_above_a[next] >= 0))
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
  Finder finder(on_a, a, on_b, b, reach_m, out, beneath_m);
  const Facing facing(a, b, std::max(reach_m, beneath_m), past_rim_m(on_a, on_b, sides, beneath_m));
  if (facing.corners_and_faces) finder.corners_over_faces(sides);
  if (facing.cones) {
    finder.edges();
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
      faced(a.corner_m[k], [&](const Vec3& normal) { return in_cone(on_a, vertex_of(on_a, a, k), normal); });
    }
    if (!a.stands_for_edge(k)) continue;
    const Side side = side_of(on_a, a, k);
    const double share = (point_m - side.from_m).dot(side.along) / (side.length_m * side.length_m);
    if (!(share > 0 && share < 1)) continue;
    faced(side.from_m + share * side.along, [&](const Vec3& normal) { return in_cone(side, normal); });
  }
  return count;
}

}  // namespace poise::collision
