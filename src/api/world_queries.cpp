// SPDX-License-Identifier: MIT
#include <utility>

#include "frame/world_state.h"
#include "poise/world.h"
#include "query/body_index.h"
#include "query/checks.h"
#include "world/validation.h"

// The questions of poise/queries.h: checked here, answered by src/query.
namespace poise {
namespace {

query::BodyViews views_of(const dynamics::BodyStore& bodies) {
  return {bodies.x_m, bodies.y_m,   bodies.z_m,   bodies.qw,         bodies.qx,    bodies.qy,
          bodies.qz,  bodies.shape, bodies.alive, bodies.generation, bodies.group, bodies.collides_with};
}

/// The index of the bodies as they are now. Any thread between steps.
const query::BodyIndex& index_of(simulation::WorldState& state) {
  return state.body_index.get(state.changes, [&](query::BodyIndex& index) { index.update(views_of(state.bodies)); });
}

}  // namespace

Result<std::optional<RayHit>> World::cast_ray(const Ray& ray, const QueryFilter& filter) const {
  if (auto bad = query::check(ray)) return *bad;
  return index_of(*state_).cast_ray(views_of(state_->bodies), ray, filter);
}

Result<std::optional<SphereCastHit>> World::cast_sphere(const SphereCast& cast, const QueryFilter& filter) const {
  if (auto bad = query::check(cast)) return *bad;
  return index_of(*state_).cast_sphere(views_of(state_->bodies), cast, filter);
}

Status World::overlap_sphere(const Vec3& center_m, double radius_m, std::vector<BodyId>& found,
                             const QueryFilter& filter) const {
  if (auto bad = query::check_point("center_m", center_m)) return *bad;
  if (auto bad = query::check_length("radius_m", radius_m)) return *bad;
  index_of(*state_).overlap_sphere(views_of(state_->bodies), center_m, radius_m, filter, found);
  return Done{};
}

Status World::overlap_box(const OrientedBox& box, std::vector<BodyId>& found, const QueryFilter& filter) const {
  if (auto bad = query::check(box)) return *bad;
  index_of(*state_).overlap_box(views_of(state_->bodies), box, filter, found);
  return Done{};
}

Result<std::optional<ClosestPoint>> World::closest_point(const Vec3& point_m, double max_distance_m,
                                                         const QueryFilter& filter) const {
  if (auto bad = query::check_point("point_m", point_m)) return *bad;
  if (auto bad = query::check_distance(max_distance_m)) return *bad;
  return index_of(*state_).closest_point(views_of(state_->bodies), point_m, max_distance_m, filter);
}

Result<ClosestPoint> World::closest_point(BodyId body, const Vec3& point_m) const {
  if (!contains(body)) return simulation::stale_body(body);
  if (auto bad = query::check_point("point_m", point_m)) return *bad;
  return index_of(*state_).closest_point(views_of(state_->bodies), body, point_m);
}

}  // namespace poise
