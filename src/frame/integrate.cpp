// SPDX-License-Identifier: MIT
#include "frame/integrate.h"

#include "dynamics/rotation.h"
#include "frame/kinematic.h"
#include "parallel/shared_counters.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kBodyGrain = 128;

void clear_forces(dynamics::BodyStore& bodies, std::size_t i) {
  bodies.set_force(i, Vec3::Zero());
  bodies.set_torque(i, Vec3::Zero());
  bodies.pushed[i] = 0;
}

// Backtracking: puts a body that was stopped where it stands, with its new velocities.
StepMotion place_stopped(const Trajectory& trajectory, dynamics::BodyStore& bodies, std::size_t slot) {
  const double sine =
      (trajectory.stands.rotation.orientation * trajectory.start.rotation.orientation.conjugate()).vec().norm();
  bodies.set_position(slot, trajectory.stands.position_m);
  bodies.set_orientation(
      slot, (trajectory.stands.rotation.orientation * bodies.shape[slot]->principal_axes.conjugate()).normalized());
  bodies.set_velocity(slot, trajectory.velocity_mps);
  bodies.set_spin(slot, trajectory.stands.rotation.spin_radps);
  clear_forces(bodies, slot);
  return {trajectory.stands.position_m - trajectory.start.position_m,
          2.0 * bodies.shape[slot]->bounding_radius_m * sine};
}

StepMotion integrate_body(const Velocities& velocities, double h_s, dynamics::BodyStore& bodies, std::size_t i) {
  const solver::SolverBody& solved = velocities.bodies[i];
  const solver::Acceleration& acceleration = velocities.accelerations[i];
  // A body that no contact held flies on a parabola, exactly: h (v+ + v_next) / 2.
  const Vec3 moved =
      solved.solved ? solved.moved_m : Vec3(h_s * solved.velocity_mps - (0.5 * h_s * h_s) * acceleration.linear_mps2);
  bodies.set_position(i, bodies.position(i) + moved);
  bodies.set_velocity(i, solved.velocity_mps);
  const Quat before = bodies.orientation(i);
  const Quat& axes = bodies.shape[i]->principal_axes;
  dynamics::Rotation rotation{bodies.orientation(i) * axes, solved.spin_radps};
  rotation = dynamics::turned_freely(rotation, bodies.principal_kgm2[i], h_s);
  if (solved.solved) {
    // What contacts turned the body beyond its spin, as where they pushed it out of an overlap. Its angular momentum
    // stays.
    const Quat turn = dynamics::rotation_by(solved.turned_rad - h_s * solved.spin_radps);
    rotation = dynamics::turned_by(rotation, bodies.principal_kgm2[i], turn);
  }
  bodies.set_orientation(i, (rotation.orientation * axes.conjugate()).normalized());
  bodies.set_spin(i, rotation.spin_radps);
  // A point of the surface moves along a chord of its turn.
  const double sine = (bodies.orientation(i) * before.conjugate()).vec().norm();
  const StepMotion motion = {moved, 2.0 * bodies.shape[i]->bounding_radius_m * sine};
  if (bodies.pushed[i] != 0) clear_forces(bodies, i);
  return motion;
}

}  // namespace

void integrate(const IntegrateInput& input, dynamics::BodyStore& bodies, StepMotions& motions,
               parallel::Executor& executor) {
  const Velocities& velocities = input.velocities;
  const double dt_s = input.dt_s;
  const std::vector<std::uint32_t>& visited = input.motion.visited;
  motions.of_slot.resize(bodies.slot_count());
  parallel::parallel_for(executor, visited.size(), kBodyGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t i = visited[k];
      motions.of_slot[i] = StepMotion{};
      if (bodies.kinematic[i] != 0) motions.of_slot[i] = move_kinematic(bodies, i, dt_s);
      bodies.changed[i] = 0;
      if (bodies.dynamic[i] == 0) continue;
      if (velocities.bodies[i].held) {
        ++bodies.frames_held[i];
        continue;
      }
      bodies.frames_held[i] = 0;
      const Trajectory* stopped = velocities.swept.stopped(i);
      motions.of_slot[i] =
          stopped != nullptr ? place_stopped(*stopped, bodies, i) : integrate_body(velocities, dt_s, bodies, i);
      bodies.changed[i] = 0;
    }
  });
}

}  // namespace poise::simulation
