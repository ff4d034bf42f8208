// SPDX-License-Identifier: MIT
#include "collision/triangles/polygon_points.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace poise::collision {
namespace {

// Shares of the smaller body's radius. A point farther than the first beyond the nearest one does not support the pair
// yet; penetration deeper than the second is searched along the crossing curve. Chosen: the reach of the contact cache
// between frames, and the skin.
constexpr double kReach = 1.5e-2;
constexpr double kBeneath = 1e-2;
// Of deep penetration: how much deeper than the impact contact a corner may lie, and the largest depth reported.
constexpr double kDeeper = 1.5;
constexpr double kDeepest = 0.25;
// From this share of what was looked through on, corners may lie deeper.
constexpr double kNearlyBeneath = 0.8;
// Points that reach this share of the depth of the impact contact replace it.
constexpr double kExplained = 0.33;
// Triangles at the crossing that are looked at again, of each body.
constexpr std::size_t kAgain = 24;
// Pairs of triangles that span the contact of two bodies, see points_reach_m. Chosen: two boxes have fewer.
constexpr std::uint32_t kMany = 64;
constexpr std::uint32_t kMostHalvings = 16;
// Rounding of gaps, and more than b is displaced by.
constexpr double kTouching = 1e-6;
constexpr std::uint8_t kAllFeatures = 0x3f;

double size_m(const PairFrame& frame) {
  const double radius_a = frame.a->bounding_radius_m;
  return frame.with_plane() ? radius_a : std::min(radius_a, frame.b->bounding_radius_m);
}

double narrowed(double share, std::uint32_t looked_at) {
  return share / static_cast<double>(std::uint32_t{1} << std::min(looked_at / kMany, kMostHalvings));
}

// Triangles of one body, each once.
struct FewTriangles {
  std::array<std::uint32_t, kAgain> index;
  std::size_t count = 0;
  void add(std::uint32_t triangle) {
    const auto end = index.begin() + static_cast<std::ptrdiff_t>(count);
    if (count == kAgain || triangle == ShapeSurface::kNone || std::find(index.begin(), end, triangle) != end) return;
    index[count++] = triangle;
  }
};

// Those that the curve of the crossing runs through, evenly along it where there are many, then those beside them.
FewTriangles triangles_at_crossing(const PlacedSurface& on, const PolygonSums& sums, bool of_a) {
  FewTriangles found;
  const std::size_t kept = std::min<std::size_t>(sums.segments, PolygonSums::kRetainedSegments);
  const std::size_t stride = std::max<std::size_t>(1, kept / kAgain);
  for (std::size_t i = 0; i < kept; i += stride) found.add(of_a ? sums.kept[i].triangle_a : sums.kept[i].triangle_b);
  const std::size_t crossed = found.count;
  for (std::size_t i = 0; i < crossed; ++i) {
    for (const std::uint32_t beyond : on.surface->triangles[found.index[i]].across) found.add(beyond);
  }
  return found;
}

}  // namespace

double points_reach_m(const PairFrame& frame, double least_m, std::uint32_t looked_at) {
  return std::min(frame.margin_m, std::max(0.0, least_m) + narrowed(kReach, looked_at) * size_m(frame));
}

double points_beneath_m(const PairFrame& frame, std::uint32_t looked_at) {
  return narrowed(kBeneath, looked_at) * size_m(frame);
}

void add_facing_point(const FacingFeatures& feature, std::uint64_t order, PointList& points) {
  std::uint64_t corner = FoundPoint::kNoCorner;
  if (feature.corner != FacingFeatures::kNoCorner)
    corner = std::uint64_t{feature.corner} << 1U | (feature.corner_of_b ? 1U : 0U);
  points.add({feature.normal, 0.5 * (feature.point_a_m + feature.point_b_m), feature.gap_m, order, corner,
              static_cast<std::uint32_t>(feature.kind), feature.in_groove});
}

DeeperSearch begin_deeper(const PairFrame& frame, const PolygonSums& sums, const PairContact& contact,
                          std::uint32_t looked_at, bool meshes, PointList& points) {
  DeeperSearch search;
  if (!contact.present) return search;
  const double size = size_m(frame);
  const double depth = -contact.estimated_separation_m;
  // Two meshes that nowhere cross do not overlap, unless one is inside the other. A side of one that runs beside a side
  // of the other, where a face of it is touched, looks as if they had passed each other.
  if (meshes && !sums.crossed && depth <= 0) points.remove_below(-kTouching * size);
  search.on = sums.crossed && depth > kNearlyBeneath * points_beneath_m(frame, looked_at);
  search.beneath_m = std::min(kDeeper * depth, kDeepest * size);
  return search;
}

bool look_deeper(const PlacedSurface& on_a, const PlacedSurface& on_b, const PolygonSums& sums, DeeperSearch& search,
                 PointList& points) {
  if (!search.on) return false;
  const FewTriangles of_a = triangles_at_crossing(on_a, sums, true);
  if (search.rows >= of_a.count) return false;
  const FewTriangles of_b = triangles_at_crossing(on_b, sums, false);
  // The triangles that answer for a corner or a side need not be among these; what is found twice is merged.
  const auto placed = [](const PlacedSurface& on, std::uint32_t triangle) {
    PlacedTriangle t;
    place(on, triangle, t);
    t.features = kAllFeatures;
    t.spread_rad = ShapeSurface::kAnyDirection;
    return t;
  };
  const PlacedTriangle a = placed(on_a, of_a.index[search.rows++]);
  for (std::size_t j = 0; j < of_b.count; ++j) {
    const PlacedTriangle b = placed(on_b, of_b.index[j]);
    const double balls = a.radius_m + b.radius_m + search.beneath_m;
    const PlaneSides sides = plane_sides(a, b);
    if ((a.center_m - b.center_m).squaredNorm() > balls * balls || beyond(sides, search.beneath_m)) continue;
    FeatureList features;
    const std::size_t count = facing_features(on_a, a, on_b, b, sides, 0.0, features, search.beneath_m);
    const std::uint64_t order = std::uint64_t{a.index} << 32U | b.index;
    for (std::size_t k = 0; k < count; ++k) add_facing_point(features[k], order, points);
  }
  return true;
}

ManifoldPoints manifold_points_of(const PairFrame& frame, const Mat3& rotation_a, const PairContact& contact,
                                  std::uint32_t looked_at, PointList& points) {
  if (!contact.present) return {};
  const double size = size_m(frame);
  const double depth = -contact.estimated_separation_m;
  const bool deep = depth > kNearlyBeneath * points_beneath_m(frame, looked_at);
  const double length = contact.direction.norm();
  const Vec3 normal = length > 0 ? Vec3(rotation_a.transpose() * contact.direction / length) : Vec3(Vec3::UnitZ());
  // The impact contact replaces features that were not found. Where points penetrate in other directions too, its depth
  // along their mean is not used; nor is it in shallow penetration, where a normal that leans a little makes much of
  // it.
  const bool found = points.count() > 0 && (depth <= 0 || points.least_gap_m() < 0);
  const bool too_shallow = deep && points.least_gap_m() > -kExplained * depth && points.overlaps_only_along(normal);
  if (!found || too_shallow) {
    points.add({normal, rotation_a.transpose() * contact.arm_m, contact.estimated_separation_m, FoundPoint::kNoCorner,
                FoundPoint::kNoCorner, static_cast<std::uint32_t>(FacingFeatures::Kind::Other) + 1, false});
  }
  return points.choose(std::max(points_reach_m(frame, points.least_gap_m()), points.least_gap_m() + kTouching * size));
}

}  // namespace poise::collision
