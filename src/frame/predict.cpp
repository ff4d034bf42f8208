// SPDX-License-Identifier: MIT
#include "frame/predict.h"

#include <algorithm>
#include <utility>

#include "collision/front/pair_refinement.h"
#include "frame/ccd/swept.h"
#include "parallel/ranges.h"
#include "parallel/shared_counters.h"

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

BodyBounds make_body_bounds(const PredictInput& input, const collision::Pose& pose, const Mat3& inverse_inertia,
                            std::size_t i) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const double dt_s = input.terms.dt_s;
  const Shape& shape = *bodies.shape[i];
  BodyBounds made;
  made.dynamic = bodies.dynamic[i] != 0;
  made.meshed = shape.surface != nullptr;
  if (shape.kind == ShapeKind::Plane) {
    made.plane = true;
    made.place = BodyBounds::Place::Plane;
    made.position_m.noalias() = pose.rotation * shape.plane_normal;
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
  if (made.depth == 0 && !made.meshed && made.radius_m == root.radius_m) made.place = BodyBounds::Place::Ball;
  made.estimated_radius_m = made.root_radius_m - collision::coarsest_lift_m(shape);
  if (!bodies.moves(i)) return made;
  made.velocity_mps = bodies.velocity(i);
  double turned_rad = bodies.spin(i).norm() * dt_s;
  if (bodies.pushed[i] != 0) {
    turned_rad += (inverse_inertia * bodies.torque(i)).norm() * dt_s * dt_s;
    made.own_m = bodies.force(i).norm() * bodies.inverse_mass[i] * dt_s * dt_s;
  }
  // The surface turns at most across the body.
  made.own_m += std::min(turned_rad, 2.0) * made.radius_m;
  return made;
}

// The bodies that must be looked at.
void list_visited(const PredictInput& input, PredictedMotion& motion, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const bool everything = std::exchange(motion.everything, false);
  parallel::select(
      executor, bodies.slot_count(), kPredictGrain, motion.counts,
      [&](std::size_t i) { return everything || bodies.changed[i] != 0 || bodies.moves(i); },
      [&](std::size_t count) { motion.visited.resize(count); },
      [&](std::size_t i, std::size_t position) { motion.visited[position] = static_cast<std::uint32_t>(i); });
}

// The bounds of bodies that move and are not swept, in order of slots; with backtracking, which does not keep those at
// rest, of all bodies.
void list_bounds(const PredictInput& input, PredictedMotion& motion, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const bool all = input.terms.backtracking;
  const auto slot_of = [&](std::size_t k) { return all ? static_cast<std::uint32_t>(k) : motion.visited[k]; };
  parallel::select(
      executor, all ? bodies.slot_count() : motion.visited.size(), kPredictGrain, motion.counts,
      [&](std::size_t k) {
        const std::uint32_t i = slot_of(k);
        return bodies.alive[i] != 0 && !motion.body_bounds[i].plane && (all || bodies.moves(i)) &&
               !motion.swept.fast(i);
      },
      [&](std::size_t count) { motion.bounds.resize(count); },
      [&](std::size_t k, std::size_t position) {
        const std::uint32_t i = slot_of(k);
        motion.bounds[position] = motion_bound_of(input.scene, motion, i);
      });
}

// All planes, if one of them may be another than before.
void list_planes(const PredictInput& input, PredictedMotion& motion) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  if (!motion.planes_changed) return;
  motion.planes_changed = false;
  motion.planes.clear();
  for (std::uint32_t i = 0; i < bodies.slot_count(); ++i) {
    if (bodies.alive[i] == 0 || !motion.body_bounds[i].plane) continue;
    motion.planes.push_back(
        {motion.body_bounds[i].position_m, motion.body_bounds[i].bound_m, i, bodies.group[i], bodies.collides_with[i]});
  }
}

}  // namespace

collision::MotionBound motion_bound_of(const SceneView& scene, const PredictedMotion& motion, std::uint32_t slot) {
  const dynamics::BodyStore& bodies = scene.bodies;
  // A body that moves by itself has to wake what sleeps in its way. Without sleepers the broad phase need not look.
  const bool wakes = bodies.asleep_count() > 0 && bodies.moves_by_itself(slot);
  const BodyBounds& bounds = motion.body_bounds[slot];
  return {bounds.position_m,
          bounds.bound_m,
          slot,
          bodies.group[slot],
          bodies.collides_with[slot],
          bodies.dynamic[slot] != 0 || wakes};
}

void predict(const PredictInput& input, PredictedMotion& motion, parallel::Executor& executor) {
  const dynamics::BodyStore& bodies = input.scene.bodies;
  const std::size_t slots = bodies.slot_count();
  parallel::resize(executor, motion.poses, slots);
  parallel::resize<Mat3>(executor, motion.inverse_inertia, slots, Mat3::Zero());
  parallel::resize(executor, motion.body_bounds, slots);
  parallel::resize<Vec3>(executor, motion.spins_radps, slots, Vec3::Zero());
  // Backtracking keeps nothing of what rests.
  if (motion.swept.on != input.terms.backtracking) motion.everything = true;
  list_visited(input, motion, executor);
  parallel::Shared<int> planes(0);
  parallel::parallel_for(executor, motion.visited.size(), kPredictGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t i = motion.visited[k];
      if (motion.body_bounds[i].plane && planes.get() == 0) planes.set(1);
      if (bodies.alive[i] == 0) continue;
      motion.poses[i] = {bodies.position(i), bodies.orientation(i).toRotationMatrix()};
      motion.inverse_inertia[i] = dynamics::inverse_inertia_world(bodies, i);
      motion.spins_radps[i] = bodies.spin(i);
      motion.body_bounds[i] = make_body_bounds(input, motion.poses[i], motion.inverse_inertia[i], i);
      if (motion.body_bounds[i].plane && planes.get() == 0) planes.set(1);
    }
  });
  motion.planes_changed = motion.planes_changed || planes.get() != 0;
  if (input.terms.backtracking || motion.swept.on) begin_swept(input, motion.swept);
  for (std::size_t i = 0; input.terms.backtracking && i < slots; ++i) {
    if (bodies.alive[i] != 0) sweep_if_fast(input, static_cast<std::uint32_t>(i), motion.swept);
  }
  list_bounds(input, motion, executor);
  list_planes(input, motion);
}

}  // namespace poise::simulation
