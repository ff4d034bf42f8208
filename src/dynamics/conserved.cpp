// SPDX-License-Identifier: MIT
#include "dynamics/conserved.h"

namespace poise::dynamics {
namespace {

// Numbers one by one: vectors that are written number by number and read in pairs are waited for, and here each would
// be.
struct Three {
  double x = 0, y = 0, z = 0;
};
Three cross(const Three& a, const Three& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double dot(const Three& a, const Three& b) { return (a.x * b.x + a.y * b.y) + a.z * b.z; }
// By the quaternion (w, q), as Eigen does it.
Three turned(double w, const Three& q, const Three& v) {
  const Three half = cross(q, v);
  const Three twice{half.x + half.x, half.y + half.y, half.z + half.z};
  const Three rest = cross(q, twice);
  return {(v.x + w * twice.x) + rest.x, (v.y + w * twice.y) + rest.y, (v.z + w * twice.z) + rest.z};
}
void add(const Three& of, Three& to) {
  to.x += of.x;
  to.y += of.y;
  to.z += of.z;
}

}  // namespace

Conserved conserved_sums(const BodyStore& bodies, const Vec3& gravity_mps2, std::size_t begin, std::size_t end) {
  const Three gravity{gravity_mps2.x(), gravity_mps2.y(), gravity_mps2.z()};
  Three momentum, angular_momentum;
  double kinetic_j = 0;
  double potential_j = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (bodies.dynamic[i] == 0 && bodies.asleep[i] == 0) continue;
    const double kg = bodies.mass_kg[i];
    const Three x{bodies.x_m[i], bodies.y_m[i], bodies.z_m[i]};
    const Three v{bodies.vx_mps[i], bodies.vy_mps[i], bodies.vz_mps[i]};
    const Quat turn = principal_to_world(bodies, i);
    const Three axis{turn.x(), turn.y(), turn.z()};
    const Three spin =
        turned(turn.w(), {-axis.x, -axis.y, -axis.z}, {bodies.wx_radps[i], bodies.wy_radps[i], bodies.wz_radps[i]});
    const Vec3& moments = bodies.principal_kgm2[i];
    const Three spun{moments.x() * spin.x, moments.y() * spin.y, moments.z() * spin.z};
    const Three p{kg * v.x, kg * v.y, kg * v.z};
    add(p, momentum);
    const Three orbits = cross(x, p);
    const Three spins = turned(turn.w(), axis, spun);
    add({orbits.x + spins.x, orbits.y + spins.y, orbits.z + spins.z}, angular_momentum);
    kinetic_j += 0.5 * (dot(p, v) + dot(spin, spun));
    potential_j -= kg * dot(gravity, x);
  }
  Conserved sums;
  sums.momentum_ns = {momentum.x, momentum.y, momentum.z};
  sums.angular_momentum_js = {angular_momentum.x, angular_momentum.y, angular_momentum.z};
  sums.kinetic_j = kinetic_j;
  sums.potential_j = potential_j;
  return sums;
}

}  // namespace poise::dynamics
