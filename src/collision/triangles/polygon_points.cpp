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
constexpr std::uint8_t kAllFeatures = 0x3f;

double size_m(const PairFrame& frame) {
  const double radius_a = frame.a->bounding_radius_m;
  return frame.with_plane() ? radius_a : std::min(radius_a, frame.b->bounding_radius_m);
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

// Looks for features as deep as `beneath_m` among the triangles where the surfaces cross.
void look_deeper(const PlacedSurface& on_a, const PlacedSurface& on_b, const PolygonSums& sums, double beneath_m,
                 PointList& points) {
  const FewTriangles of_a = triangles_at_crossing(on_a, sums, true);
  const FewTriangles of_b = triangles_at_crossing(on_b, sums, false);
  std::array<PlacedTriangle, kAgain> b;
  for (std::size_t j = 0; j < of_b.count; ++j) {
    place(on_b, of_b.index[j], b[j]);
    b[j].features = kAllFeatures;
  }
  for (std::size_t i = 0; i < of_a.count; ++i) {
    PlacedTriangle a;
    place(on_a, of_a.index[i], a);
    // The triangles that answer for a corner or a side need not be among these; what is found twice is merged.
    a.features = kAllFeatures;
    for (std::size_t j = 0; j < of_b.count; ++j) {
      const double balls = a.radius_m + b[j].radius_m + beneath_m;
      const PlaneSides sides = plane_sides(a, b[j]);
      if ((a.center_m - b[j].center_m).squaredNorm() > balls * balls || beyond(sides, beneath_m)) continue;
      FeatureList features;
      const std::size_t count = facing_features(on_a, a, on_b, b[j], sides, 0.0, features, beneath_m);
      const std::uint64_t order = std::uint64_t{a.index} << 32U | b[j].index;
      for (std::size_t k = 0; k < count; ++k) add_facing_point(features[k], order, points);
    }
  }
}

}  // namespace

double points_reach_m(const PairFrame& frame, double least_m) {
  return std::min(frame.margin_m, std::max(0.0, least_m) + kReach * size_m(frame));
}

double points_beneath_m(const PairFrame& frame) { return kBeneath * size_m(frame); }

void add_facing_point(const FacingFeatures& feature, std::uint64_t order, PointList& points) {
  std::uint64_t corner = FoundPoint::kNoCorner;
  if (feature.corner != FacingFeatures::kNoCorner)
    corner = std::uint64_t{feature.corner} << 1U | (feature.corner_of_b ? 1U : 0U);
  points.add({feature.normal, 0.5 * (feature.point_a_m + feature.point_b_m), feature.gap_m, order, corner,
              static_cast<std::uint32_t>(feature.kind), feature.in_groove});
}

ManifoldPoints manifold_points_of(const PairFrame& frame, const Mat3& rotation_a, const PlacedSurface& on_a,
                                  const PlacedSurface& on_b, const PolygonSums& sums, const PairContact& contact,
                                  PointList& points) {
  if (!contact.present) return {};
  const double size = size_m(frame);
  const double depth = -contact.estimated_separation_m;
  const bool deep = depth > kNearlyBeneath * points_beneath_m(frame);
  if (sums.crossed && deep) {
    look_deeper(on_a, on_b, sums, std::min(kDeeper * depth, kDeepest * size), points);
  }
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
  return points.choose(std::max(points_reach_m(frame, points.least_gap_m()), points.least_gap_m() + 1e-6 * size));
}

}  // namespace poise::collision
