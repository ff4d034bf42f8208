// SPDX-License-Identifier: MIT
#pragma once

#include "solver/contact_solver.h"
#include "solver/contacts/contact_blocks.h"
#include "solver/contacts/split_system.h"

namespace poise::solver {

/// Motion of a body in a step without contacts; impulses are added to it.
inline void fly(const SplitSystem& system, std::size_t i, double dt_s) {
  SolverBody& body = system.body(i);
  body.moved_m = dt_s * body.velocity_mps;
  body.turned_rad = dt_s * body.spin_radps;
  const Acceleration& pull = system.acceleration_of(i);
  body.velocity_mps += dt_s * pull.linear_mps2;
  body.spin_radps += dt_s * pull.angular_radps2;
}

/// Where its change of motion in the step leads a body, on top of its flight.
template <class T>
void land(const MotionChange<T>& motion, SolverBody& body) {
  body.moved_m +=
      Vec3(static_cast<double>(motion.x[0]), static_cast<double>(motion.x[1]), static_cast<double>(motion.x[2]));
  body.turned_rad +=
      Vec3(static_cast<double>(motion.q[0]), static_cast<double>(motion.q[1]), static_cast<double>(motion.q[2]));
}

}  // namespace poise::solver
