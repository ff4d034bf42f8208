// SPDX-License-Identifier: MIT
#include "query/inner_solids.h"

#include <algorithm>
#include <array>

#include "query/body_surface.h"
#include "query/bvh_walk.h"
#include "query/triangle_queries.h"

namespace poise::query {
namespace {

// Beyond rounding of the tests that stop a box.
constexpr double kShrink = 1 - 1e-6;
constexpr int kBisections = 8;

std::vector<InnerSolid> largest_leaves(const SphereTree& tree) {
  std::vector<InnerSolid> leaves;
  for (NodeIndex node = 0; node < tree.node_count(); ++node) {
    if (tree.child_count[node] > 0) continue;
    const Sphere sphere = tree.sphere(node);
    leaves.push_back({sphere.center_m, sphere.radius_m, Vec3::Zero()});
  }
  std::stable_sort(leaves.begin(), leaves.end(),
                   [](const InnerSolid& x, const InnerSolid& y) { return x.radius_m > y.radius_m; });
  if (leaves.size() > kMostInnerSolids) leaves.resize(kMostInnerSolids);
  return leaves;
}

bool meets_surface(const geometry::TriangleBvh& triangles, const Vec3& low, const Vec3& high) {
  const Vec3 center = 0.5 * (low + high);
  const Vec3 half = 0.5 * (high - low);
  bool met = false;
  walk(
      triangles,
      [&](const Vec3& box_low, const Vec3& box_high) {
        return (box_low.array() <= high.array()).all() && (box_high.array() >= low.array()).all() ? 0.0 : kMiss;
      },
      [] { return 0.0; },
      [&](std::uint32_t place) {
        const geometry::TriangleCorners& t = triangles.corners_at(place);
        met = triangle_meets_box({t[0] - center, t[1] - center, t[2] - center}, half);
        return met;
      });
  return met;
}

// A box without triangles around a point that is inside: first in the proportions of the whole, then side by side.
geometry::Bounds grown_box(const BodySurface& surface, const Vec3& seed) {
  const geometry::TriangleBvh& triangles = surface.shape()->surface->bvh;
  const geometry::Bounds& whole = surface.box();
  const auto between = [&](double share) {
    return geometry::Bounds{seed + share * (whole.low - seed), seed + share * (whole.high - seed)};
  };
  double least = 0, most = 1;
  for (int i = 0; i < kBisections; ++i) {
    const double share = 0.5 * (least + most);
    const geometry::Bounds box = between(share);
    (meets_surface(triangles, box.low, box.high) ? most : least) = share;
  }
  geometry::Bounds box = between(least);
  if (least == 0) return box;
  for (Eigen::Index side = 0; side < 6; ++side) {
    const Eigen::Index axis = side % 3;
    const bool upper = side >= 3;
    double near = upper ? box.high[axis] : box.low[axis];
    double far = upper ? whole.high[axis] : whole.low[axis];
    for (int i = 0; i < kBisections; ++i) {
      const double middle = 0.5 * (near + far);
      geometry::Bounds larger = box;
      (upper ? larger.high : larger.low)[axis] = middle;
      (meets_surface(triangles, larger.low, larger.high) ? far : near) = middle;
    }
    (upper ? box.high : box.low)[axis] = near;
  }
  return box;
}

bool holds(const InnerSolid& box, const Vec3& point) {
  return ((point - box.center_m).cwiseAbs().array() <= box.half_extents_m.array()).all();
}

std::vector<InnerSolid> grown_boxes(const BodySurface& surface) {
  constexpr std::array<double, 3> kShares{0.5, 1.0 / 6, 5.0 / 6};
  const geometry::Bounds& whole = surface.box();
  std::vector<InnerSolid> boxes;
  for (const double x : kShares) {
    for (const double y : kShares) {
      for (const double z : kShares) {
        const Vec3 seed = whole.low + Vec3(x, y, z).cwiseProduct(whole.high - whole.low);
        const bool known = std::any_of(boxes.begin(), boxes.end(), [&](const InnerSolid& b) { return holds(b, seed); });
        if (known || !surface.contains(seed)) continue;
        const geometry::Bounds box = grown_box(surface, seed);
        const Vec3 half = 0.5 * kShrink * (box.high - box.low);
        if (half.minCoeff() > 0) boxes.push_back({0.5 * (box.low + box.high), 0, half});
      }
    }
  }
  std::stable_sort(boxes.begin(), boxes.end(), [](const InnerSolid& x, const InnerSolid& y) {
    return x.half_extents_m.prod() > y.half_extents_m.prod();
  });
  if (boxes.size() > kMostInnerSolids) boxes.resize(kMostInnerSolids);
  return boxes;
}

}  // namespace

std::vector<InnerSolid> inner_solids(const ShapePtr& shape) {
  if (shape->kind == ShapeKind::Plane) return {};
  if (!shape->surface) return largest_leaves(shape->tree);
  if (!shape->surface->solid) return {};
  return grown_boxes(BodySurface(shape));
}

}  // namespace poise::query
