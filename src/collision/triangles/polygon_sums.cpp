// SPDX-License-Identifier: MIT
#include "collision/triangles/polygon_sums.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace poise::collision {
namespace {

// A gap that is larger by this share of the smaller body's radius has half the weight. Chosen: as fine as a touch is
// told apart in docs/method.md (1e-4 of the size), so that two corners count together only where nothing could say
// which is first.
constexpr double kSoftness = 1e-4;
// Ten halvings: what weighs a thousandth is left out.
constexpr double kHalvings = 10;
// A curve whose area vector is smaller than this share of what its parts iteration encloses nothing; far above
// rounding.
constexpr double kEnclosing = 1e-9;
// Curves that stay open by more than this share of their length have lost a piece; their moment is not to be trusted.
constexpr double kOpen = 1e-6;
// Of a sum of normals: shorter means that they oppose each other.
constexpr double kOpposed = 1e-3;
constexpr int kClimbingSteps = 16;
constexpr int kAskedNeighbors = 3;
constexpr std::size_t kClimbs = 2;
// Of the faces at a crossing: how many are looked at, how near their normals must be to the gradient's (the cosine),
// from where on two are one, and what share of the gradient's depth theirs must be below. Chosen: round surfaces keep
// the gradient.
constexpr std::size_t kFaces = 6;
constexpr double kEstimated = 0.9;
constexpr double kSameFace = 1e-6;
constexpr double kFarSooner = 0.7;

// 2^-x for x >= 0, to 1e-8: products and sums alone, the same bits on every machine, which exp of a library does not
// promise.
double halved(double x) {
  const double whole = std::floor(x);
  if (whole > 60) return 0;
  const double y = -0.693147180559945309 * (x - whole);
  double sum = 1;
  for (int k = 8; k > 0; --k) sum = 1 + sum * (y / k);
  return std::ldexp(sum, -static_cast<int>(whole));
}

// Contact of a pair: unit direction and moment about the centre of mass of a, in the frame of a.
struct Answer {
  Vec3 direction = Vec3::Zero();
  Vec3 moment_m = Vec3::Zero();
  Vec3 point_m = Vec3::Zero();
  double gap_m = 0;
};

PairContact contact_of(const PairFrame& frame, const Answer& answer, const Mat3& rotation_a) {
  PairContact contact;
  contact.direction = rotation_a * answer.direction;
  contact.moment_a_m = rotation_a * answer.moment_m;
  contact.moment_b_m = rotation_a * (answer.moment_m - frame.offset_m.cross(answer.direction));
  contact.arm_m = rotation_a * answer.point_m;
  contact.spheres_m = contact.estimated_separation_m = contact.certain_separation_m = answer.gap_m;
  contact.present = true;
  return contact;
}

// The contact of the leaves with the gap of the polygons; without one (trees of one node) along the line of centres.
PairContact by_leaves(const PairFrame& frame, const PairContact& leaves, double gap_m, const Mat3& rotation_a) {
  PairContact contact = leaves;
  if (!leaves.present) {
    Answer answer;
    const double distance = frame.offset_m.norm();
    answer.direction = distance > 0 ? Vec3(frame.offset_m / distance) : Vec3(Vec3::UnitZ());
    answer.point_m = 0.5 * frame.offset_m;
    answer.moment_m = answer.point_m.cross(answer.direction);
    contact = contact_of(frame, answer, rotation_a);
  }
  contact.spheres_m = contact.estimated_separation_m = contact.certain_separation_m = gap_m;
  return contact;
}

bool inside(const PlacedSurface& placed, const Vec3& point) {
  return placed.surface != nullptr && placed.surface->solid &&
         placed.surface->bvh.inside(placed.rotation.transpose() * (point - placed.offset_m));
}

// From a corner of `placed` that lies inside `other`, along its edges as far as `up` leads inside; the height reached.
double climbed(const PlacedSurface& placed, const PlacedSurface& other, const Vec3& up, std::uint32_t vertex) {
  const auto height = [&](std::uint32_t v) { return up.dot(placed.point(placed.surface->vertices_m[v])); };
  double top = height(vertex);
  for (int step = 0; step < kClimbingSteps; ++step) {
    // The highest neighbour is asked first; most often it is inside.
    double below = std::numeric_limits<double>::infinity();
    bool higher = false;
    for (int asked = 0; asked < kAskedNeighbors && !higher; ++asked) {
      double best = top;
      std::uint32_t next = vertex;
      for (const std::uint32_t neighbor : placed.surface->neighbors_of(vertex)) {
        const double there = height(neighbor);
        if (there <= best || there >= below) continue;
        best = there;
        next = neighbor;
      }
      if (next == vertex) return top;
      below = best;
      higher = inside(other, placed.point(placed.surface->vertices_m[next]));
      if (!higher) continue;
      top = best;
      vertex = next;
    }
    if (!higher) break;
  }
  return top;
}

// How far the part of `placed` that lies inside `other` reaches along `up`, beyond `top`.
double highest_inside(const PlacedSurface& placed, const PlacedSurface& other, const Vec3& up, double top, double least,
                      std::span<const RetainedSegment> kept, bool of_a) {
  for (std::size_t climb = 0; climb < kClimbs; ++climb) {
    const RetainedSegment& segment = kept[climb * kept.size() / kClimbs];
    for (const std::uint32_t v : placed.surface->triangles[of_a ? segment.triangle_a : segment.triangle_b].vertex) {
      const Vec3 point = placed.point(placed.surface->vertices_m[v]);
      if (up.dot(point) <= top + least || !inside(other, point)) continue;
      top = std::max(top, climbed(placed, other, up, v));
    }
  }
  return top;
}

// Extent of the overlap along the normal: of the curve, and of the corners of each body beneath it.
double overlap_depth_m(const PlacedSurface& on_a, const PlacedSurface& on_b, const PolygonSums& sums,
                       const Vec3& normal) {
  const std::span<const RetainedSegment> kept =
      std::span(sums.kept).first(std::min<std::size_t>(sums.segments, PolygonSums::kRetainedSegments));
  double top = -std::numeric_limits<double>::infinity();
  double bottom = std::numeric_limits<double>::infinity();
  for (const RetainedSegment& segment : kept) {
    for (const Vec3& end : {segment.from_m, segment.to_m}) {
      top = std::max(top, normal.dot(end));
      bottom = std::min(bottom, normal.dot(end));
    }
  }
  const double least = 1e-3 * sums.softness_m;
  const double high = highest_inside(on_a, on_b, normal, top, least, kept, true);
  const double low = -highest_inside(on_b, on_a, -normal, -bottom, least, kept, false);
  return high - low;
}

// Along a normal that leans a little, a face that lies flat seems to overlap by its width. The faces at the crossing
// are candidates of their own: the one out of which the other body's corner comes soonest, if by far sooner than
// `depth_m`.
struct WayOut {
  Vec3 direction;
  double depth_m;
};

// How deep `other` lies beneath a face of `placed`: of the corners of one of its triangles, and down along its edges
// from there.
double depth_beneath_m(const PlacedSurface& other, std::uint32_t triangle, const Vec3& normal, const Vec3& on_face) {
  const auto depth = [&](std::uint32_t v) { return normal.dot(on_face - other.point(other.surface->vertices_m[v])); };
  std::uint32_t vertex = other.surface->triangles[triangle].vertex[0];
  for (const std::uint32_t v : other.surface->triangles[triangle].vertex) {
    if (depth(v) > depth(vertex)) vertex = v;
  }
  for (int step = 0; step < kClimbingSteps; ++step) {
    std::uint32_t next = vertex;
    for (const std::uint32_t neighbor : other.surface->neighbors_of(vertex)) {
      if (depth(neighbor) > depth(next)) next = neighbor;
    }
    if (next == vertex) break;
    vertex = next;
  }
  return depth(vertex);
}

WayOut shortest_way_out(const PlacedSurface& on_a, const PlacedSurface& on_b, const PolygonSums& sums,
                        const WayOut& first) {
  WayOut best = first;
  best.depth_m *= kFarSooner;
  bool found = false;
  std::array<Vec3, kFaces> seen;
  std::size_t count = 0;
  const auto look_at = [&](const PlacedSurface& placed, std::uint32_t face, const PlacedSurface& other,
                           std::uint32_t triangle, double sign) {
    const ShapeSurface::Triangle& t = placed.surface->triangles[face];
    const Vec3 normal = placed.rotation * t.normal;
    const Vec3 direction = sign * normal;
    if (count == kFaces || direction.dot(first.direction) < kEstimated) return;
    for (std::size_t i = 0; i < count; ++i) {
      if (seen[i].dot(direction) > 1 - kSameFace) return;
    }
    seen[count++] = direction;
    const double depth =
        depth_beneath_m(other, triangle, normal, placed.point(placed.surface->vertices_m[t.vertex[0]]));
    if (depth >= best.depth_m) return;
    best = {direction, std::max(depth, 0.0)};
    found = true;
  };
  for (std::size_t i = 0; i < std::min<std::size_t>(sums.segments, PolygonSums::kRetainedSegments); ++i) {
    look_at(on_a, sums.kept[i].triangle_a, on_b, sums.kept[i].triangle_b, 1.0);
    look_at(on_b, sums.kept[i].triangle_b, on_a, sums.kept[i].triangle_a, -1.0);
  }
  return found ? best : first;
}

// Adds the facing features to what the crossing says, as far as they are no farther than softness allows.
Answer with_features(const PolygonSums& sums, Answer answer, double weight) {
  const double scale = sums.weight > 0 ? halved(std::max(0.0, sums.least_gap_m - answer.gap_m) / sums.softness_m) : 0.0;
  const Vec3 normal = weight * answer.direction + scale * sums.normal;
  const double length = normal.norm();
  const double total = weight + scale * sums.weight;
  if (!(length > kOpposed * total)) return answer;
  answer.moment_m = (weight * answer.moment_m + scale * sums.moment_m) / length;
  answer.point_m = (weight * answer.point_m + scale * sums.point_m) / total;
  answer.direction = normal / length;
  return answer;
}

PairContact finish_crossing(const PairFrame& frame, const PlacedSurface& on_a, const PlacedSurface& on_b,
                            const PolygonSums& sums, const PairContact& leaves, const Mat3& rotation_a) {
  const Vec3 toward = leaves.present ? Vec3(rotation_a.transpose() * leaves.direction) : frame.offset_m;
  const double area = sums.area_m2.norm();
  if (!(area > kEnclosing * sums.swept_m2)) {
    const double length = toward.norm();
    const double depth = length > 0 ? overlap_depth_m(on_a, on_b, sums, toward / length) : 0.0;
    return by_leaves(frame, leaves, -depth, rotation_a);
  }
  Answer answer;
  answer.direction = sums.area_m2 / area;
  const bool solids = on_a.surface->solid && on_b.surface->solid;
  // A sheet does not tell its two sides apart; what the leaves say does.
  if (!solids && answer.direction.dot(toward) < 0) answer.direction = -answer.direction;
  answer.point_m = sums.reference_m + sums.middle_m2 / sums.length_m;
  const bool closed = solids && sums.open_m.norm() <= kOpen * sums.length_m;
  answer.moment_m = closed ? Vec3(sums.lever_m3 / area + sums.reference_m.cross(answer.direction))
                           : answer.point_m.cross(answer.direction);
  WayOut way{answer.direction, overlap_depth_m(on_a, on_b, sums, answer.direction)};
  if (solids) way = shortest_way_out(on_a, on_b, sums, way);
  if (way.direction != answer.direction) {
    // The line of action keeps its place.
    const Vec3 on_line =
        answer.direction.cross(answer.moment_m) + answer.point_m.dot(answer.direction) * answer.direction;
    answer.direction = way.direction;
    answer.moment_m = on_line.cross(way.direction);
  }
  answer.gap_m = -way.depth_m;
  return contact_of(frame, with_features(sums, answer, 1.0), rotation_a);
}

// True if b, whose surface is nowhere near a's, lies inside it: tests its first corner, or its first leaf where it has
// none.
bool swallows(const PlacedSurface& on_a, const Shape& a, const PlacedSurface& on_b, const Shape& b) {
  if (on_a.surface == nullptr || !on_a.surface->solid || !(b.bounding_radius_m < 2 * a.bounding_radius_m)) return false;
  const Vec3 body = on_b.surface != nullptr ? on_b.surface->vertices_m[on_b.surface->triangles[0].vertex[0]]
                                            : b.tree.sphere(static_cast<NodeIndex>(b.tree.node_count() - 1)).center_m;
  return inside(on_a, on_b.point(body));
}

}  // namespace

double polygon_softness_m(const PairFrame& frame) {
  const double radius_a = frame.a->bounding_radius_m;
  return kSoftness * (frame.with_plane() ? radius_a : std::min(radius_a, frame.b->bounding_radius_m));
}

double reach_of_sums_m(const PairFrame& frame, const PolygonSums& sums, double most_m) {
  const double least = std::min(sums.crossed ? std::min(0.0, sums.least_gap_m) : sums.least_gap_m, most_m);
  return std::min(frame.margin_m, least + kHalvings * sums.softness_m);
}

void add_feature(const FacingFeatures& feature, PolygonSums& sums) {
  double weight = 1;
  if (feature.gap_m < sums.least_gap_m) {
    const double scale = sums.weight > 0 ? halved((sums.least_gap_m - feature.gap_m) / sums.softness_m) : 0.0;
    sums.weight *= scale;
    sums.normal *= scale;
    sums.moment_m *= scale;
    sums.point_m *= scale;
    sums.least_gap_m = feature.gap_m;
  } else {
    weight = halved((feature.gap_m - sums.least_gap_m) / sums.softness_m);
  }
  const Vec3 point = 0.5 * (feature.point_a_m + feature.point_b_m);
  const Vec3 normal = weight * feature.normal;
  sums.weight += weight;
  sums.normal += normal;
  sums.moment_m += point.cross(normal);
  sums.point_m += weight * point;
}

void add_segment(const CrossingSegment& segment, std::uint32_t triangle_a, std::uint32_t triangle_b,
                 PolygonSums& sums) {
  if (!sums.crossed) sums.reference_m = segment.from_m;
  sums.crossed = true;
  const Vec3 from = segment.from_m - sums.reference_m;
  const Vec3 to = segment.to_m - sums.reference_m;
  const Vec3 step = to - from;
  const double length = step.norm();
  // Half of x cross dx integrates to half of from cross to; |x|^2 over the segment to a third of the sum below.
  const Vec3 swept = 0.5 * from.cross(to);
  sums.area_m2 += swept;
  sums.swept_m2 += swept.norm();
  sums.lever_m3 -= (from.squaredNorm() + from.dot(to) + to.squaredNorm()) / 6.0 * step;
  sums.open_m += step;
  sums.length_m += length;
  sums.middle_m2 += 0.5 * length * (from + to);
  if (sums.segments < PolygonSums::kRetainedSegments) {
    sums.kept[sums.segments] = {segment.from_m, segment.to_m, triangle_a, triangle_b};
  }
  ++sums.segments;
}

void add_sunk_ball(const SunkBall& ball, PolygonSums& sums) {
  if (ball.gap_m > sums.sunk.gap_m) sums.sunk = ball;
}

PairContact make_polygon_contact(const PairFrame& frame, const PlacedSurface& on_a, const PlacedSurface& on_b,
                                 const PolygonSums& sums, const PairContact& leaves, const Mat3& rotation_a) {
  if (sums.crossed) return finish_crossing(frame, on_a, on_b, sums, leaves, rotation_a);
  if (std::isfinite(sums.sunk.gap_m) && inside(sums.sunk.of_b ? on_a : on_b, sums.sunk.center_m)) {
    Answer answer;
    answer.direction = sums.sunk.normal;
    answer.point_m = sums.sunk.point_m;
    answer.moment_m = answer.point_m.cross(answer.direction);
    answer.gap_m = sums.sunk.gap_m;
    return contact_of(frame, answer, rotation_a);
  }
  if (sums.weight > 0) {
    Answer answer;
    answer.gap_m = sums.least_gap_m;
    answer.point_m = sums.point_m / sums.weight;
    const Answer all = with_features(sums, answer, 0.0);
    if (!all.direction.isZero(0)) return contact_of(frame, all, rotation_a);
    return by_leaves(frame, leaves, sums.least_gap_m, rotation_a);
  }
  if (!frame.with_plane() && (swallows(on_a, *frame.a, on_b, *frame.b) || swallows(on_b, *frame.b, on_a, *frame.a))) {
    return by_leaves(frame, leaves, std::min(0.0, leaves.present ? leaves.estimated_separation_m : 0.0), rotation_a);
  }
  return PairContact{};
}

}  // namespace poise::collision
