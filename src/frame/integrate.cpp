// SPDX-License-Identifier: MIT
#include "frame/integrate.h"

#include <algorithm>

#include "dynamics/rotation.h"
#include "frame/kinematic.h"
#include "parallel/shared_counters.h"
#include "world/validation.h"

namespace poise::simulation {
namespace {

constexpr std::size_t kBodyGrain = 128;

void clear_forces(dynamics::BodyStore& bodies, std::size_t i) {
  bodies.set_force(i, Vec3::Zero());
  bodies.set_torque(i, Vec3::Zero());
  bodies.pushed[i] = 0;
}

// Backtracking: a body that was stopped stays where it stands, with its new velocities.
MovedBody moved_until_stopped(const Trajectory& trajectory, const dynamics::BodyStore& bodies, std::size_t slot) {
  const double sine =
      (trajectory.stands.rotation.orientation * trajectory.start.rotation.orientation.conjugate()).vec().norm();
  const Quat& axes = bodies.shape[slot]->principal_axes;
  return {
      {trajectory.stands.position_m, (trajectory.stands.rotation.orientation * axes.conjugate()).normalized(),
       trajectory.velocity_mps, trajectory.stands.rotation.spin_radps},
      {trajectory.stands.position_m - trajectory.start.position_m, 2.0 * bodies.shape[slot]->bounding_radius_m * sine}};
}

MovedBody moved_for(double h_s, const Velocities& velocities, const dynamics::BodyStore& bodies, std::size_t i) {
  const solver::SolverBody& solved = velocities.bodies[i];
  const solver::Acceleration& acceleration = velocities.acceleration_of(i);
  // A body that no contact held flies on a parabola, exactly: h (v+ + v_next) / 2.
  const Vec3 moved_m =
      solved.solved ? solved.moved_m : Vec3(h_s * solved.velocity_mps - (0.5 * h_s * h_s) * acceleration.linear_mps2);
  const Quat before = bodies.orientation(i);
  const Quat& axes = bodies.shape[i]->principal_axes;
  dynamics::Rotation rotation{before * axes, solved.spin_radps};
  rotation = dynamics::turned_freely(rotation, bodies.principal_kgm2[i], h_s);
  if (solved.solved) {
    // What contacts turned the body beyond its spin, as where they pushed it out of an overlap. Its angular momentum
    // stays; under gravity that of the heap does not, and what lies must not sink into what it lies on.
    const Quat turn = dynamics::rotation_by(solved.turned_rad - h_s * solved.spin_radps);
    const auto keeps = solved.pulled ? dynamics::TurnKeeps::Turn : dynamics::TurnKeeps::Momentum;
    rotation = dynamics::turned_by(rotation, bodies.principal_kgm2[i], turn, keeps);
  }
  const Quat after = (rotation.orientation * axes.conjugate()).normalized();
  // A point of the surface moves along a chord of its turn.
  const double sine = (after * before.conjugate()).vec().norm();
  return {{bodies.position(i) + moved_m, after, solved.velocity_mps, rotation.spin_radps},
          {moved_m, 2.0 * bodies.shape[i]->bounding_radius_m * sine}};
}

// Sets the new state, if it is one; true if it is.
bool set_in_range(const BodyState& state, dynamics::BodyStore& bodies, std::size_t i) {
  if (!in_range(state)) {
    bodies.set_velocity(i, Vec3::Zero());
    bodies.set_spin(i, Vec3::Zero());
    return false;
  }
  bodies.set_position(i, state.position_m);
  bodies.set_orientation(i, state.orientation);
  bodies.set_velocity(i, state.velocity_mps);
  bodies.set_spin(i, state.angular_velocity_radps);
  return true;
}

}  // namespace

void integrate(const IntegrateInput& input, dynamics::BodyStore& bodies, StepMotions& motions,
               parallel::Executor& executor) {
  const Velocities& velocities = input.velocities;
  const double dt_s = input.dt_s;
  const std::vector<std::uint32_t>& visited = input.motion.visited;
  motions.of_slot.resize(bodies.slot_count());
  motions.out_of_range.clear();
  parallel::Tickets out_of_range;
  parallel::parallel_for(executor, visited.size(), kBodyGrain, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t i = visited[k];
      motions.of_slot[i] = StepMotion{};
      bodies.changed[i] = 0;
      const bool driven = bodies.moves_by_itself(i);
      if (!driven && bodies.dynamic[i] == 0) continue;
      if (!driven && velocities.bodies[i].held) {
        ++bodies.frames_held[i];
        continue;
      }
      const Trajectory* stopped = driven ? nullptr : velocities.swept.stopped(i);
      const MovedBody moved = driven               ? moved_by_itself(bodies, i, dt_s)
                              : stopped != nullptr ? moved_until_stopped(*stopped, bodies, i)
                                                   : moved_for(dt_s, velocities, bodies, i);
      bodies.frames_held[i] = 0;
      if (bodies.pushed[i] != 0) clear_forces(bodies, i);
      if (set_in_range(moved.state, bodies, i)) {
        motions.of_slot[i] = moved.motion;
        bodies.changed[i] = 0;
        continue;
      }
      bodies.changed[i] = 1;
      out_of_range.take(1);
    }
  });
  if (out_of_range.take(0) == 0) return;
  for (const std::uint32_t i : visited) {
    if (bodies.changed[i] != 0) motions.out_of_range.push_back(i);
  }
  std::ranges::sort(motions.out_of_range);
}

}  // namespace poise::simulation
