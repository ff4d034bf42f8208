// SPDX-License-Identifier: MIT
#include "frame/kinematic.h"

#include "dynamics/rotation.h"

namespace poise::simulation {

MovedBody moved_by_itself(const dynamics::BodyStore& bodies, std::size_t slot, double dt_s) {
  const Vec3 moved_m = dt_s * bodies.velocity(slot);
  const Vec3 spin = bodies.spin(slot);
  MovedBody moved{{bodies.position(slot) + moved_m, bodies.orientation(slot), bodies.velocity(slot), spin},
                  {moved_m, 0}};
  if (spin.isZero(0)) return moved;
  const Quat turn = dynamics::rotation_by(dt_s * spin);
  moved.state.orientation = (turn * bodies.orientation(slot)).normalized();
  // A point of the surface moves along a chord of its turn.
  moved.motion.turned_m = 2.0 * bodies.shape[slot]->bounding_radius_m * turn.vec().norm();
  return moved;
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
