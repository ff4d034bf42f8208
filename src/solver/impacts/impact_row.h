// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "poise/types.h"

namespace poise::solver {

/// A body as the solver sees it. Pairs of a colour gather and scatter it; what they read is the first cache line.
struct alignas(64) SolverBody {
  Vec3 velocity_mps = Vec3::Zero();
  Vec3 spin_radps = Vec3::Zero();
  double inverse_mass = 0;         ///< 0 for bodies that are not dynamic; these are never written
  bool solved = false;             ///< resting contact changed its motion in this step
  bool pulled = false;             ///< an external acceleration acts on it
  bool held = false;               ///< it waits in this step: nothing is solved of it
  std::uint32_t acceleration = 0;  ///< which external acceleration acts on it
  Vec3 moved_m = Vec3::Zero();     ///< in the step so far
  Vec3 turned_rad = Vec3::Zero();  ///< in the step so far
};
static_assert(sizeof(SolverBody) == 128);

/// One sphere contact of a pair, world frame, for the contact model that solves each by itself.
struct PointContact {
  Vec3 normal = Vec3::UnitZ();  ///< from a to b
  Vec3 arm_a_m = Vec3::Zero();  ///< point - x_a
  Vec3 arm_b_m = Vec3::Zero();  ///< point - x_b
  double gap_m = 0;
};

/// A direction along which two bodies push each other: (l, t_a, t_b), see docs/method.md.
struct Wrench {
  Vec3 direction = Vec3::Zero();                              ///< l
  Vec3 moment_a_m = Vec3::Zero(), moment_b_m = Vec3::Zero();  ///< t_a, t_b
  double effective_mass = 0;                                  ///< 1 / K; 0 when degenerate: it is inactive
};

/// What a unit impulse along a wrench adds to the spins: I_a^-1 t_a, I_b^-1 t_b.
struct Turns {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
};

/// The constraint row of one pair: a single constraint along the wrench. Four cache lines: what says whether an impulse
/// is needed stands in the first two, because most looks at a row end with that. Lanes read it in fours of numbers
/// (impact_lanes.cpp), so its order is fixed.
struct alignas(64) ContactRow {
  Wrench wrench;
  double gap_m = 0;  ///< estimated separation of the two surfaces
  double restitution = 0;
  Vec3 a_to_b_m = Vec3::Zero();  ///< between the centres of mass
  double overlap_reach_m = 0;    ///< from the centre of mass of a to the farthest of its OverlapPoints

  Turns turns;
  Vec3 arm_m = Vec3::Zero();                       ///< mean contact point, from the centre of mass of a
  double total_ns = 0;                             ///< all that b received along l from impacts
  double friction = 0;                             ///< Coulomb's coefficient
  std::uint32_t a = 0, b = 0;                      ///< solver bodies; a pair's order, not that of slots
  Vec3 point_impulse_ns = Vec3::Zero();            ///< what point contacts and friction gave to b from impacts
  std::uint32_t points_begin = 0, points_end = 0;  ///< of the point contacts, when the model needs them

  /// What impacts gave to b, N s. A row that was never filled has no direction, and gave nothing along it.
  [[nodiscard]] Vec3 impact_ns() const {
    return total_ns == 0 ? point_impulse_ns : Vec3(total_ns * wrench.direction + point_impulse_ns);
  }
};
static_assert(sizeof(ContactRow) == 256);

/// A contact point of a manifold that certainly penetrates, at the start of the step. Lanes read it in fours of numbers
/// too.
struct OverlapPoint {
  Vec3 normal = Vec3::UnitZ();                                ///< from a to b
  Vec3 moment_a_m = Vec3::Zero(), moment_b_m = Vec3::Zero();  ///< r x n about each centre of mass
  double restitution = 0;                                     ///< of the row
};
static_assert(sizeof(OverlapPoint) == 80);

/// Fills the effective mass of a wrench and its turns; true unless K is not positive and finite (then the wrench is
/// left without effect).
bool prepare_wrench(double inverse_mass_a, const Mat3& inverse_inertia_a, double inverse_mass_b,
                    const Mat3& inverse_inertia_b, Wrench& wrench, Turns& turns);

/// Approach speed along a wrench or at a point: positive when the two close.
inline double approach_mps(const Vec3& direction, const Vec3& moment_a_m, const Vec3& moment_b_m, const SolverBody& a,
                           const SolverBody& b) {
  return direction.dot(a.velocity_mps - b.velocity_mps) + moment_a_m.dot(a.spin_radps) - moment_b_m.dot(b.spin_radps);
}
inline double approach_mps(const Wrench& wrench, const SolverBody& a, const SolverBody& b) {
  return approach_mps(wrench.direction, wrench.moment_a_m, wrench.moment_b_m, a, b);
}

/// Applies the impulse lambda along the wrench to b and its opposite to a. Bodies that are not dynamic stay as they
/// are.
inline void apply_impulse(const Wrench& wrench, const Turns& turns, double lambda_ns, SolverBody& a, SolverBody& b) {
  if (a.inverse_mass > 0) {
    a.velocity_mps -= (lambda_ns * a.inverse_mass) * wrench.direction;
    a.spin_radps -= lambda_ns * turns.a;
  }
  if (b.inverse_mass > 0) {
    b.velocity_mps += (lambda_ns * b.inverse_mass) * wrench.direction;
    b.spin_radps += lambda_ns * turns.b;
  }
}

}  // namespace poise::solver
