// SPDX-License-Identifier: MIT
#include "frame/kinematic.h"

#include "dynamics/rotation.h"

namespace poise::simulation {

StepMotion move_kinematic(dynamics::BodyStore& bodies, std::size_t slot, double dt_s) {
  if (!bodies.moves_by_itself(slot)) return {};
  const Vec3 moved_m = dt_s * bodies.velocity(slot);
  bodies.set_position(slot, bodies.position(slot) + moved_m);
  const Vec3 spin = bodies.spin(slot);
  if (spin.isZero(0)) return {moved_m, 0};
  const Quat turn = dynamics::rotation_by(dt_s * spin);
  bodies.set_orientation(slot, (turn * bodies.orientation(slot)).normalized());
  // A point of the surface moves along a chord of its turn.
  return {moved_m, 2.0 * bodies.shape[slot]->bounding_radius_m * turn.vec().norm()};
}

void drive_trajectory(const dynamics::BodyStore& bodies, std::uint32_t slot, double dt_s, Trajectory& trajectory) {
  trajectory.start.velocity_mps = bodies.velocity(slot);
  trajectory.start.rotation.spin_radps = bodies.spin(slot);
  // With equal moments a spin stays what it is.
  trajectory.start.moments_kgm2 = Vec3::Ones();
  trajectory.stands = trajectory.start;
  trajectory.velocity_mps = bodies.velocity(slot);
  trajectory.stop_s = dt_s;
}

}  // namespace poise::simulation
