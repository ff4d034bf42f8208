// SPDX-License-Identifier: MIT
#include "oracle/exact_response.h"

#include <Eigen/LU>

namespace poise::oracle {
namespace {

struct Side {
  double mass_kg;
  Mat3 inverse_inertia;  // world
  Vec3 arm_m;
};

Side side_of(const OracleMesh& body, const Placed& at, const Vec3& point_m) {
  const Mat3 turn = at.orientation.toRotationMatrix();
  return {body.mass_kg(), turn * body.inertia_kgm2().inverse() * turn.transpose(), point_m - at.position_m};
}

// Inverse effective mass of the body's point along n: n . (n / m + (I^-1 (r x n)) x r).
double inverse_effective_mass(const Side& side, const Vec3& n) {
  return 1 / side.mass_kg + n.dot((side.inverse_inertia * side.arm_m.cross(n)).cross(side.arm_m));
}

}  // namespace

Answer exact_answer(const OracleMesh& a, const Flight& flight_a, const OracleMesh& b, const Flight& flight_b,
                    const FirstTouch& touch, double restitution) {
  Answer answer;
  if (touch.outcome != FlightOutcome::Touch) return answer;
  const Vec3& n = touch.nearest.normal;
  const Vec3 point = 0.5 * (touch.nearest.on_a_m + touch.nearest.on_b_m);
  const Side side_a = side_of(a, touch.a, point);
  const Side side_b = side_of(b, touch.b, point);
  const Vec3 speed_a = flight_a.velocity_mps + flight_a.spin_radps.cross(side_a.arm_m);
  const Vec3 speed_b = flight_b.velocity_mps + flight_b.spin_radps.cross(side_b.arm_m);
  answer.approach_mps = n.dot(speed_a - speed_b);
  if (!(answer.approach_mps > 0)) return answer;
  const double impulse_ns =
      (1 + restitution) * answer.approach_mps / (inverse_effective_mass(side_a, n) + inverse_effective_mass(side_b, n));
  answer.dv_a_mps = -impulse_ns / side_a.mass_kg * n;
  answer.dw_a_radps = -impulse_ns * (side_a.inverse_inertia * side_a.arm_m.cross(n));
  answer.dv_b_mps = impulse_ns / side_b.mass_kg * n;
  answer.dw_b_radps = impulse_ns * (side_b.inverse_inertia * side_b.arm_m.cross(n));
  return answer;
}

}  // namespace poise::oracle
