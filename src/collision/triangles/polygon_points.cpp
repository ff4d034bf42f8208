// SPDX-License-Identifier: MIT
#include "collision/triangles/polygon_points.h"

#include <algorithm>
#include <array>
#include <bit>
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
// Pairs of triangles that span the contact of two bodies, see points_reach_m. Chosen: two boxes have fewer.
constexpr std::uint32_t kMany = 64;
constexpr std::uint32_t kMostHalvings = 16;
// Rounding of gaps, and more than b is displaced by.
constexpr double kTouching = 1e-6;

double size_m(const PairFrame& frame) {
  const double radius_a = frame.a->bounding_radius_m;
  return frame.with_plane() ? radius_a : std::min(radius_a, frame.b->bounding_radius_m);
}

double narrowed(double share, std::uint32_t looked_at) {
  return share / static_cast<double>(std::uint32_t{1} << std::min(looked_at / kMany, kMostHalvings));
}

// Those that the curve of the crossing runs through, evenly along it where there are many, then those beside them.
void find_triangles_at_crossing(const PlacedSurface& on, const PolygonSums& sums, bool of_a, CrossingTriangles& found) {
  const std::size_t kept = std::min<std::size_t>(sums.segments, PolygonSums::kRetainedSegments);
  const std::size_t stride = std::max<std::size_t>(1, kept / CrossingTriangles::kMost);
  for (std::size_t i = 0; i < kept; i += stride) {
    found.add(on, of_a ? sums.kept[i].triangle_a : sums.kept[i].triangle_b);
  }
  const std::size_t crossed = found.count();
  for (std::size_t i = 0; i < crossed; ++i) {
    for (const std::uint32_t beyond : on.surface->triangles[found[i].index].across) found.add(on, beyond);
  }
}

// Is a side of a triangle one that can touch first, whichever of the two triangles there owns it?
bool touches_first(const ShapeSurface& surface, std::uint32_t index, std::size_t k) {
  const ShapeSurface::Triangle& t = surface.triangles[index];
  if ((t.features & (ShapeSurface::kEdge0 << k)) != 0 || t.across[k] == ShapeSurface::kNone) return true;
  const ShapeSurface::Triangle& other = surface.triangles[t.across[k]];
  for (std::size_t m = 0; m < 3; ++m) {
    if (other.across[m] == index && (other.features & (ShapeSurface::kEdge0 << m)) != 0) return true;
  }
  return false;
}

}  // namespace

// The triangles that own a corner or a side need not be among these.
void CrossingTriangles::add(const PlacedSurface& on, std::uint32_t index) {
  if (count_ == kMost || index == ShapeSurface::kNone) return;
  const ShapeSurface::Triangle& t = on.surface->triangles[index];
  std::uint32_t shared = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const std::uint32_t other = triangle_[i].index;
    if (other == index) return;
    for (std::size_t k = 0; k < 3; ++k) shared |= (t.across[k] == other ? 1U : 0U) << k;
  }
  const auto known = [this](std::uint32_t vertex) {
    if ((vertex_bits_ >> (vertex & 63U) & 1U) == 0) return false;
    const auto end = vertex_.begin() + static_cast<std::ptrdiff_t>(3 * count_);
    return std::find(vertex_.begin(), end, vertex) != end;
  };
  std::uint32_t features = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if ((shared >> k & 1U) == 0 && touches_first(*on.surface, index, k))
      features |= std::uint32_t{ShapeSurface::kEdge0} << k;
    if (!known(t.vertex[k])) features |= std::uint32_t{ShapeSurface::kVertex0} << k;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    vertex_[3 * count_ + k] = t.vertex[k];
    vertex_bits_ |= std::uint64_t{1} << (t.vertex[k] & 63U);
  }
  place_with_features(on, index, static_cast<std::uint8_t>(features), triangle_[count_]);
  near_[count_] = on.surface->near_triangles[on.surface->bvh.place_of(index)];
  near_[count_].features = static_cast<float>(features);
  near_[count_].spread_rad = ShapeSurface::kAnyDirection;
  ++count_;
}

void CrossingTriangles::fill(std::array<NearRows, kRows>& rows) const {
  for (std::size_t i = 0; count_ > 0 && i < kRows * NearRows::kPairs; ++i) {
    rows[i / NearRows::kPairs].set(i % NearRows::kPairs, near_[std::min(i, count_ - 1)]);
  }
}

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

void begin_deeper(const PairFrame& frame, const PlacedSurface& on_a, const PlacedSurface& on_b, const PolygonSums& sums,
                  const PairContact& contact, std::uint32_t looked_at, DeeperSearch& search, PointList& points) {
  if (!contact.present) return;
  const double size = size_m(frame);
  const double depth = -contact.estimated_separation_m;
  const bool meshes = on_a.surface != nullptr && on_b.surface != nullptr;
  // Two meshes that nowhere cross do not overlap, unless one is inside the other. A side of one that runs beside a side
  // of the other, where a face of it is touched, looks as if they had passed each other.
  if (meshes && !sums.crossed && depth <= 0) points.remove_below(-kTouching * size);
  search.on = sums.crossed && depth > kNearlyBeneath * points_beneath_m(frame, looked_at);
  if (!search.on) return;
  search.beneath_m = std::min(kDeeper * depth, kDeepest * size);
  find_triangles_at_crossing(on_a, sums, true, search.of_a);
  find_triangles_at_crossing(on_b, sums, false, search.of_b);
  search.of_b.fill(search.rows_of_b);
}

bool look_deeper(const PlacedSurface& on_a, const PlacedSurface& on_b, const SurfaceDescent& descent,
                 DeeperSearch& search, PointList& points) {
  if (!search.on || search.rows >= search.of_a.count()) return false;
  const std::size_t row = search.rows++;
  const PlacedTriangle& a = search.of_a[row];
  const TriangleTest test = descent.test({0, search.beneath_m});
  NearRows rows_a;
  for (std::size_t k = 0; k < NearRows::kPairs; ++k) rows_a.set(k, search.of_a.near(row));
  for (std::size_t first = 0; first < search.of_b.count(); first += NearRows::kPairs) {
    const std::size_t count = std::min(NearRows::kPairs, search.of_b.count() - first);
    const NearRows& rows_b = search.rows_of_b[first / NearRows::kPairs];
    std::uint32_t left = compare_triangles(descent.frame(), test, rows_a, rows_b).may_face & ((1U << count) - 1);
    for (; left != 0; left &= left - 1) {
      const PlacedTriangle& b = search.of_b[first + static_cast<std::size_t>(std::countr_zero(left))];
      FeatureList features;
      const std::size_t found = facing_features(on_a, a, on_b, b, plane_sides(a, b), 0.0, features, search.beneath_m);
      const std::uint64_t order = std::uint64_t{a.index} << 32U | b.index;
      for (std::size_t k = 0; k < found; ++k) add_facing_point(features[k], order, points);
    }
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
