// SPDX-License-Identifier: MIT
#include "frame/predict.h"

#include <algorithm>

#include "collision/front/pair_refinement.h"
#include "frame/ccd/swept.h"
#include "parallel/ranges.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kPredictGrain = 512;

double motion_bound_m(const PredictInput& input, std::size_t slot) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const double speed = bodies.velocity(slot).norm();
  if (bodies.kinematic[slot] != 0) return speed * input.terms.dt_s;
  if (bodies.dynamic[slot] == 0) return 0;
  double acceleration = input.terms.gravity_mps2.norm();
  if (bodies.pushed[slot] != 0) acceleration += bodies.force(slot).norm() * bodies.inverse_mass[slot];
  return (speed + acceleration * input.terms.dt_s) * input.terms.dt_s;
}

// Does the body move and have to wake what sleeps in its way? Without sleepers the broad phase need not look.
bool wakes(const dynamics::BodyStore& bodies, std::size_t i) {
  return bodies.asleep_count() > 0 && bodies.moves_by_itself(i);
}

BodyBounds make_body_bounds(const PredictInput& input, const collision::Pose& pose, std::size_t i) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const double dt_s = input.terms.dt_s;
  const Shape& shape = *bodies.shape[i];
  BodyBounds made;
  made.dynamic = bodies.dynamic[i] != 0;
  made.meshed = shape.surface != nullptr;
  if (shape.kind == ShapeKind::Plane) {
    made.plane = true;
    made.position_m = pose.rotation * shape.plane_normal;
    made.bound_m = made.position_m.dot(pose.position_m) + shape.plane_offset_m;
    return made;
  }
  made.position_m = pose.position_m;
  made.depth = shape.tree.depth();
  made.radius_m = shape.bounding_radius_m;
  made.bound_m = made.radius_m * (1.0 + kSkin) + motion_bound_m(input, i);
  const Sphere root = shape.tree.sphere(0);
  made.root_center_m = pose.position_m + pose.rotation * root.center_m;
  made.root_radius_m = root.radius_m;
  made.estimated_radius_m = made.root_radius_m - collision::coarsest_lift_m(shape);
  made.velocity_mps = bodies.velocity(i);
  // The surface moves by the spin at most across the body.
  made.own_m = std::min(bodies.spin(i).norm() * dt_s, 2.0) * made.radius_m;
  if (bodies.pushed[i] != 0) made.own_m += bodies.force(i).norm() * bodies.inverse_mass[i] * dt_s * dt_s;
  return made;
}

// The bounds of bodies that are not swept, and of planes, in order of slots.
void list_bounds(const PredictInput& input, PredictedMotion& motion, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const std::size_t slots = bodies.slot_count();
  parallel::select(
      executor, slots, kPredictGrain, motion.counts,
      [&](std::size_t i) {
        return bodies.alive[i] != 0 && !motion.body_bounds[i].plane &&
               !motion.swept.fast(static_cast<std::uint32_t>(i));
      },
      [&](std::size_t count) { motion.bounds.resize(count); },
      [&](std::size_t i, std::size_t position) {
        motion.bounds[position] = {motion.body_bounds[i].position_m, motion.body_bounds[i].bound_m,
                                   static_cast<std::uint32_t>(i),    bodies.group[i],
                                   bodies.collides_with[i],          bodies.dynamic[i] != 0 || wakes(bodies, i)};
      });
  parallel::select(
      executor, slots, kPredictGrain, motion.counts,
      [&](std::size_t i) { return bodies.alive[i] != 0 && motion.body_bounds[i].plane; },
      [&](std::size_t count) { motion.planes.resize(count); },
      [&](std::size_t i, std::size_t position) {
        motion.planes[position] = {motion.body_bounds[i].position_m, motion.body_bounds[i].bound_m,
                                   static_cast<std::uint32_t>(i), bodies.group[i], bodies.collides_with[i]};
      });
}

}  // namespace

void predict(const PredictInput& input, PredictedMotion& motion, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const std::size_t slots = bodies.slot_count();
  motion.poses.resize(slots);
  motion.inverse_inertia.resize(slots);
  motion.body_bounds.resize(slots);
  parallel::parallel_for(executor, slots, kPredictGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      if (bodies.alive[i] == 0) continue;
      motion.poses[i] = {bodies.position(i), bodies.orientation(i).toRotationMatrix()};
      motion.inverse_inertia[i] = dynamics::inverse_inertia_world(bodies, i);
      motion.body_bounds[i] = make_body_bounds(input, motion.poses[i], i);
    }
  });
  if (input.terms.backtracking || motion.swept.on) begin_swept(input, motion.swept);
  for (std::size_t i = 0; input.terms.backtracking && i < slots; ++i) {
    if (bodies.alive[i] != 0) sweep_if_fast(input, static_cast<std::uint32_t>(i), motion.swept);
  }
  list_bounds(input, motion, executor);
}

}  // namespace poise::simulation
