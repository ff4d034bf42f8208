// SPDX-License-Identifier: MIT
#include "solver/contacts/angular_balance.h"

#include <Eigen/LU>

#include <cmath>
#include <cstddef>

namespace poise::solver {
namespace {

template <class T>
Vec3 lane_of(const T (&from)[3][kLanes], std::size_t lane) {
  return {static_cast<double>(from[0][lane]), static_cast<double>(from[1][lane]), static_cast<double>(from[2][lane])};
}

template <class T>
void set_lane(const Vec3& from, std::size_t lane, T (&into)[3][kLanes]) {
  for (std::size_t k = 0; k < 3; ++k) into[k][lane] = static_cast<T>(from[static_cast<Eigen::Index>(k)]);
}

template <class Visit>
void for_shifted(const ContactBlock& block, Visit&& visit) {
  for (std::size_t lane = 0; lane < block.count; ++lane) {
    if ((std::uint32_t{block.shifted} >> lane & 1U) != 0) visit(lane);
  }
}

// Two bodies in the frame of their common centre of mass, at the end of the step.
struct TwoBodies {
  Vec3 apart_m = Vec3::Zero();  // from a to b
  double reduced_kg = 0;
  Mat3 inertia_a_kgm2 = Mat3::Zero(), inertia_b_kgm2 = Mat3::Zero();
  [[nodiscard]] Mat3 inertia_kgm2() const {
    const Mat3 square = apart_m.squaredNorm() * Mat3::Identity() - apart_m * apart_m.transpose();
    return inertia_a_kgm2 + inertia_b_kgm2 + reduced_kg * square;
  }
};
struct TwoMotions {
  Vec3 apart_mps = Vec3::Zero();  // velocity of b against a
  Vec3 spin_a_radps = Vec3::Zero(), spin_b_radps = Vec3::Zero();
};

double energy_j(const TwoBodies& bodies, const TwoMotions& motions) {
  return 0.5 * (bodies.reduced_kg * motions.apart_mps.squaredNorm() +
                motions.spin_a_radps.dot(bodies.inertia_a_kgm2 * motions.spin_a_radps) +
                motions.spin_b_radps.dot(bodies.inertia_b_kgm2 * motions.spin_b_radps));
}

Vec3 angular_momentum_js(const TwoBodies& bodies, const TwoMotions& motions) {
  return bodies.reduced_kg * bodies.apart_m.cross(motions.apart_mps) + bodies.inertia_a_kgm2 * motions.spin_a_radps +
         bodies.inertia_b_kgm2 * motions.spin_b_radps;
}

// The motions plus a rotation of both bodies as one.
TwoMotions turned(const TwoBodies& bodies, const TwoMotions& motions, const Vec3& spin_radps) {
  return {motions.apart_mps + spin_radps.cross(bodies.apart_m), motions.spin_a_radps + spin_radps,
          motions.spin_b_radps + spin_radps};
}

// The motions after `given_js` more angular momentum and no more energy, as far as there are such; true if there are.
bool give(const TwoBodies& bodies, const Vec3& given_js, TwoMotions& motions) {
  const Mat3 per_inertia = bodies.inertia_kgm2().inverse();
  const TwoMotions given = turned(bodies, motions, per_inertia * given_js);
  const double before_j = energy_j(bodies, motions);
  const double after_j = energy_j(bodies, given);
  if (!std::isfinite(after_j)) return false;
  if (after_j <= before_j) {
    motions = given;
    return true;
  }
  // What is left if nothing moves against the rigid body of both has no angular momentum against it.
  const Vec3 sum_js = angular_momentum_js(bodies, given);
  const Vec3 rigid_radps = per_inertia * sum_js;
  const double inner_j = after_j - 0.5 * sum_js.dot(rigid_radps);
  const double left = 1 - (after_j - before_j) / inner_j;
  if (!(inner_j > 0 && left >= 0)) return false;
  const double share = std::sqrt(left);
  const TwoMotions inner = turned(bodies, given, -rigid_radps);
  motions =
      turned(bodies, {share * inner.apart_mps, share * inner.spin_a_radps, share * inner.spin_b_radps}, rigid_radps);
  return true;
}

}  // namespace

template <class T>
void add_late_impulses(const ContactBlock& block, double late_s, PairLanes<T>& shared,
                       std::span<const PointLanes<T>> manifold_points) {
  for (const PointLanes<T>& point : manifold_points) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t lane = 0; lane < block.count; ++lane) {
        shared.shift[k][lane] -=
            static_cast<T>(late_s) * (point.impulse[lane] * point.normal[k][lane] + point.friction_impulse[k][lane]);
      }
    }
  }
}

template <class T>
void measure_angular_change(const SplitSystem& system, const ContactBlock& block, PairLanes<T>& shared) {
  for_shifted(block, [&](std::size_t lane) {
    const Vec3 apart_mps = system.body(block.b[lane]).velocity_mps - system.body(block.a[lane]).velocity_mps;
    set_lane(lane_of(shared.shift, lane).cross(apart_mps), lane, shared.shift);
  });
}

template <class T>
void return_angular_momentum(const SplitSystem& system, const ContactBlock& block, const PairLanes<T>& shared) {
  for_shifted(block, [&](std::size_t lane) {
    const Vec3 added = lane_of(shared.shift, lane);
    if (added.isZero(0)) return;
    SolverBody& a = system.body(block.a[lane]);
    SolverBody& b = system.body(block.b[lane]);
    TwoBodies bodies;
    bodies.reduced_kg = 1.0 / (a.inverse_mass + b.inverse_mass);
    bodies.apart_m =
        system.pose_of(block.b[lane]).position_m + b.moved_m - (system.pose_of(block.a[lane]).position_m + a.moved_m);
    bodies.inertia_a_kgm2 = system.inverse_inertia_of(block.a[lane]).inverse();
    bodies.inertia_b_kgm2 = system.inverse_inertia_of(block.b[lane]).inverse();
    const TwoMotions before = {b.velocity_mps - a.velocity_mps, a.spin_radps, b.spin_radps};
    TwoMotions after = before;
    if (!give(bodies, -static_cast<double>(shared.reduced_mass[lane]) * added, after)) return;
    const Vec3 impulse_ns = bodies.reduced_kg * (after.apart_mps - before.apart_mps);
    system.applied_impulse_ns[block.pair[lane]] += impulse_ns;
    a.velocity_mps -= a.inverse_mass * impulse_ns;
    b.velocity_mps += b.inverse_mass * impulse_ns;
    a.spin_radps = after.spin_a_radps;
    b.spin_radps = after.spin_b_radps;
  });
}

template void add_late_impulses(const ContactBlock&, double, PairLanes<float>&, std::span<const PointLanes<float>>);
template void add_late_impulses(const ContactBlock&, double, PairLanes<double>&, std::span<const PointLanes<double>>);
template void measure_angular_change(const SplitSystem&, const ContactBlock&, PairLanes<float>&);
template void measure_angular_change(const SplitSystem&, const ContactBlock&, PairLanes<double>&);
template void return_angular_momentum(const SplitSystem&, const ContactBlock&, const PairLanes<float>&);
template void return_angular_momentum(const SplitSystem&, const ContactBlock&, const PairLanes<double>&);

}  // namespace poise::solver
