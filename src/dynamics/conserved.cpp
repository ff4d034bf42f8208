// SPDX-License-Identifier: MIT
#include "dynamics/conserved.h"

namespace poise::dynamics {

Conserved conserved_sums(const BodyStore& bodies, const Vec3& gravity_mps2, std::size_t begin, std::size_t end) {
  Conserved sums;
  for (std::size_t i = begin; i < end; ++i) {
    if (bodies.dynamic[i] == 0 && bodies.asleep[i] == 0) continue;
    const Vec3 x = bodies.position(i);
    const Vec3 v = bodies.velocity(i);
    const Quat turn = principal_to_world(bodies, i);
    const Vec3 spin_body = turn.conjugate() * bodies.spin(i);
    const Vec3 momentum_body = bodies.principal_kgm2[i].cwiseProduct(spin_body);
    const Vec3 p = bodies.mass_kg[i] * v;
    sums.momentum_ns += p;
    sums.angular_momentum_js += x.cross(p) + turn * momentum_body;
    sums.kinetic_j += 0.5 * (p.dot(v) + spin_body.dot(momentum_body));
    sums.potential_j -= bodies.mass_kg[i] * gravity_mps2.dot(x);
  }
  return sums;
}

}  // namespace poise::dynamics
