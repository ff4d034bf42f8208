// SPDX-License-Identifier: MIT
#include "query/body_index.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "query/bvh_walk.h"

namespace poise::query {
namespace {

using geometry::Bounds;

constexpr std::uint32_t kNoSurface = 0xffffffffU;

/// The world-frame box around a box of the body frame, widened by more than rounding.
Bounds placed_box(const Bounds& box, const Mat3& rotation, const Vec3& position_m) {
  const Vec3 middle = rotation * box.center() + position_m;
  const Vec3 reach = rotation.cwiseAbs() * (0.5 * (box.high - box.low));
  const Vec3 wide =
      reach + 1e-13 * (middle.cwiseAbs() + position_m.cwiseAbs() + reach) + Vec3::Constant(1e-13 * box.center().norm());
  return {middle - wide, middle + wide};
}

bool sees(const QueryFilter& filter, const BodyViews& bodies, std::uint32_t slot) {
  return (filter.group & bodies.collides_with[slot]) != 0 && (filter.collides_with & bodies.group[slot]) != 0 &&
         !(filter.ignore.slot == slot && filter.ignore.generation == bodies.generation[slot]);
}

/// Transforms a query into the frame of a body, and its result back into the world.
struct Frame {
  Mat3 rotation;
  Vec3 position_m;

  Frame(const BodyViews& bodies, std::uint32_t slot)
      : rotation(bodies.rotation(slot)), position_m(bodies.position(slot)) {}
  [[nodiscard]] Vec3 into(const Vec3& world) const { return rotation.transpose() * (world - position_m); }
  [[nodiscard]] Vec3 out(const Vec3& body) const { return rotation * body + position_m; }
  // A rotation preserves unit length except for rounding, which would show in a distance.
  [[nodiscard]] Vec3 direction_into(const Vec3& world) const { return (rotation.transpose() * world).normalized(); }
  [[nodiscard]] Vec3 direction_out(const Vec3& body) const { return (rotation * body).normalized(); }
};

}  // namespace

/// The best result so far.
struct BodyIndex::Nearest {
  double limit_m;  ///< |distance| of the best result, or the limit of the query
  std::optional<std::uint32_t> slot;
  SurfacePoint found;  ///< in the body frame

  void take(std::uint32_t candidate, const std::optional<SurfacePoint>& point) {
    if (!point) return;
    const double distance_m = std::abs(point->distance_m);
    if (distance_m > limit_m || (slot && distance_m == limit_m && candidate > *slot)) return;
    limit_m = distance_m;
    slot = candidate;
    found = *point;
  }
};

void BodyIndex::update(const BodyViews& bodies) {
  std::unordered_map<const Shape*, std::uint32_t> known;
  std::vector<std::unique_ptr<BodySurface>> before = std::move(surfaces_);
  surfaces_.clear();
  for (std::uint32_t i = 0; i < before.size(); ++i) known.emplace(before[i]->shape().get(), i);
  std::unordered_map<const Shape*, std::uint32_t> used;
  surface_of_slot_.assign(bodies.slot_count(), kNoSurface);
  std::vector<std::uint32_t> slots;
  boxes_.clear();
  planes_.clear();
  for (std::uint32_t slot = 0; slot < bodies.slot_count(); ++slot) {
    if (bodies.alive[slot] == 0) continue;
    const Shape* shape = bodies.shape[slot].get();
    const auto [entry, fresh] = used.try_emplace(shape, static_cast<std::uint32_t>(surfaces_.size()));
    if (fresh) {
      const auto old = known.find(shape);
      surfaces_.push_back(old != known.end() ? std::move(before[old->second])
                                             : std::make_unique<BodySurface>(bodies.shape[slot]));
    }
    surface_of_slot_[slot] = entry->second;
    const BodySurface& surface = *surfaces_[entry->second];
    if (surface.is_plane()) {
      planes_.push_back(slot);
      continue;
    }
    slots.push_back(slot);
    boxes_.push_back(placed_box(surface.box(), bodies.rotation(slot), bodies.position(slot)));
  }
  const bool same_bodies = slots == slot_of_box_;
  slot_of_box_ = std::move(slots);
  if (!same_bodies || !tree_.refit(boxes_)) tree_.build(boxes_);
}

template <class Bound, class Limit, class Visit>
void BodyIndex::visit_bodies(const BodyViews& bodies, const QueryFilter& filter, Bound&& bound, Limit&& limit,
                             Visit&& visit) const {
  for (const std::uint32_t slot : planes_) {
    if (sees(filter, bodies, slot)) visit(slot);
  }
  tree_.walk(bound, limit, [&](std::uint32_t i) {
    const std::uint32_t slot = slot_of_box_[i];
    if (!sees(filter, bodies, slot)) return;
    const double least = bound(boxes_[i].low, boxes_[i].high);
    if (least <= limit() && least != kMiss) visit(slot);
  });
}

std::optional<RayHit> BodyIndex::cast_ray(const BodyViews& bodies, const Ray& ray, const QueryFilter& filter) const {
  const Vec3 direction = ray.direction.stableNormalized();
  const BoxRay boxes(ray.origin_m, direction, 0);
  Nearest nearest{ray.max_distance_m, {}, {}};
  visit_bodies(
      bodies, filter, [&](const Vec3& low, const Vec3& high) { return boxes.enters_m(low, high); },
      [&] { return nearest.limit_m; },
      [&](std::uint32_t slot) {
        const Frame frame(bodies, slot);
        nearest.take(slot, surface_of(slot).cast_ray(frame.into(ray.origin_m), frame.direction_into(direction),
                                                     nearest.limit_m, ray.leaves_solids));
      });
  if (!nearest.slot) return std::nullopt;
  const Frame frame(bodies, *nearest.slot);
  const Vec3 point = nearest.found.at_start ? ray.origin_m : frame.out(nearest.found.point_m);
  return RayHit{{*nearest.slot, bodies.generation[*nearest.slot]},
                point,
                frame.direction_out(nearest.found.normal),
                nearest.found.distance_m};
}

std::optional<SphereCastHit> BodyIndex::cast_sphere(const BodyViews& bodies, const SphereCast& cast,
                                                    const QueryFilter& filter) const {
  const Vec3 direction = cast.direction.stableNormalized();
  const BoxRay boxes(cast.center_m, direction, cast.radius_m);
  Nearest nearest{cast.max_distance_m, {}, {}};
  visit_bodies(
      bodies, filter, [&](const Vec3& low, const Vec3& high) { return boxes.enters_m(low, high); },
      [&] { return nearest.limit_m; },
      [&](std::uint32_t slot) {
        const Frame frame(bodies, slot);
        nearest.take(slot, surface_of(slot).cast_sphere(frame.into(cast.center_m), cast.radius_m,
                                                        frame.direction_into(direction), nearest.limit_m));
      });
  if (!nearest.slot) return std::nullopt;
  const Frame frame(bodies, *nearest.slot);
  SphereCastHit hit;
  hit.body = {*nearest.slot, bodies.generation[*nearest.slot]};
  hit.point_m = frame.out(nearest.found.point_m);
  hit.normal = frame.direction_out(nearest.found.normal);
  hit.distance_m = nearest.found.distance_m;
  const bool finite = std::isfinite(cast.max_distance_m) && cast.max_distance_m > 0;
  hit.fraction = finite ? hit.distance_m / cast.max_distance_m : 0.0;
  hit.overlaps_at_start = nearest.found.at_start;
  return hit;
}

void BodyIndex::overlap_sphere(const BodyViews& bodies, const Vec3& center_m, double radius_m,
                               const QueryFilter& filter, std::vector<BodyId>& found) const {
  found.clear();
  visit_bodies(
      bodies, filter,
      [&](const Vec3& low, const Vec3& high) {
        return Bounds{low, high}.squared_distance(center_m) <= radius_m * radius_m * (1 + 1e-12) ? 0.0 : kMiss;
      },
      [] { return 0.0; },
      [&](std::uint32_t slot) {
        if (surface_of(slot).overlaps_ball(Frame(bodies, slot).into(center_m), radius_m))
          found.push_back({slot, bodies.generation[slot]});
      });
  std::ranges::sort(found);
}

void BodyIndex::overlap_box(const BodyViews& bodies, const OrientedBox& box, const QueryFilter& filter,
                            std::vector<BodyId>& found) const {
  found.clear();
  const Mat3 turn = box.orientation.normalized().toRotationMatrix();
  const Bounds around = placed_box({-box.half_extents_m, box.half_extents_m}, turn, box.center_m);
  visit_bodies(
      bodies, filter,
      [&](const Vec3& low, const Vec3& high) {
        return (low.array() <= around.high.array()).all() && (high.array() >= around.low.array()).all() ? 0.0 : kMiss;
      },
      [] { return 0.0; },
      [&](std::uint32_t slot) {
        const Frame frame(bodies, slot);
        const Mat3 rotation = turn.transpose() * frame.rotation;
        const Vec3 offset_m = turn.transpose() * (frame.position_m - box.center_m);
        if (surface_of(slot).overlaps_box(rotation, offset_m, box.half_extents_m))
          found.push_back({slot, bodies.generation[slot]});
      });
  std::ranges::sort(found);
}

std::optional<ClosestPoint> BodyIndex::closest_point(const BodyViews& bodies, const Vec3& point_m,
                                                     double max_distance_m, const QueryFilter& filter) const {
  Nearest nearest{max_distance_m, {}, {}};
  visit_bodies(
      bodies, filter,
      [&](const Vec3& low, const Vec3& high) {
        return std::sqrt(Bounds{low, high}.squared_distance(point_m)) * (1 - 1e-12);
      },
      [&] { return nearest.limit_m; },
      [&](std::uint32_t slot) {
        nearest.take(slot, surface_of(slot).closest(Frame(bodies, slot).into(point_m), nearest.limit_m));
      });
  if (!nearest.slot) return std::nullopt;
  const Frame frame(bodies, *nearest.slot);
  return ClosestPoint{{*nearest.slot, bodies.generation[*nearest.slot]},
                      frame.out(nearest.found.point_m),
                      frame.direction_out(nearest.found.normal),
                      nearest.found.distance_m};
}

ClosestPoint BodyIndex::closest_point(const BodyViews& bodies, BodyId body, const Vec3& point_m) const {
  const Frame frame(bodies, body.slot);
  const std::optional<SurfacePoint> found = surface_of(body.slot).closest(frame.into(point_m), kMiss);
  // A surface has a nearest point: every mesh has triangles, every tree has leaves.
  if (!found) return {body, point_m, Vec3::UnitZ(), 0};
  return {body, frame.out(found->point_m), frame.direction_out(found->normal), found->distance_m};
}

}  // namespace poise::query
