// SPDX-License-Identifier: MIT
#include "solver/contact_blocks.h"

#include <algorithm>
#include <cstddef>

namespace poise::solver {
namespace {

template <class T>
void set(const Vec3& from, std::size_t lane, T (&into)[3][kLanes]) {
  for (std::size_t k = 0; k < 3; ++k) into[k][lane] = static_cast<T>(from[static_cast<Eigen::Index>(k)]);
}

// The part of a pair that all its contact points share.
template <class T>
void fill_pair(const ContactSystem& system, const Manifold& pair, std::size_t lane, ContactBlock& block,
               PairLanes<T>& shared, StartLanes<T>& start) {
  const SolverBody& a = system.bodies[pair.a];
  const SolverBody& b = system.bodies[pair.b];
  const double unit_kg = 1.0 / (a.inverse_mass + b.inverse_mass);
  set(Vec3(system.poses[pair.b].position_m - system.poses[pair.a].position_m), lane, shared.a_to_b);
  shared.dynamic_a[lane] = static_cast<T>(unit_kg * a.inverse_mass);
  shared.dynamic_b[lane] = static_cast<T>(unit_kg * b.inverse_mass);
  shared.friction[lane] = static_cast<T>(pair.friction);
  shared.reduced_mass[lane] = static_cast<T>(unit_kg);
  set(Vec3(a.velocity_mps - b.velocity_mps), lane, start.velocity);
  set(a.spin_radps, lane, start.spin_a);
  set(b.spin_radps, lane, start.spin_b);
  start.restitution[lane] = static_cast<T>(pair.restitution);
  if (a.inverse_mass > 0) block.dynamic_a = static_cast<std::uint8_t>(block.dynamic_a | 1U << lane);
  if (b.inverse_mass > 0) block.dynamic_b = static_cast<std::uint8_t>(block.dynamic_b | 1U << lane);
  block.frictional = block.frictional || pair.friction > 0;
}

template <class T>
void fill_point(const ContactSystem& system, const Manifold& pair, double per_newton, std::size_t p, std::size_t lane,
                PointLanes<T>& into) {
  const PlacedPoint now = placed_point(system.poses[pair.a], system.poses[pair.b], system.points[pair.point_begin + p]);
  set(now.normal, lane, into.normal);
  set(now.arm_m, lane, into.arm);
  into.gap[lane] = static_cast<T>(now.gap_m);
  into.certain[lane] = static_cast<T>(now.certain_separation_m + pair.slop_m);
  into.mass[lane] = 1;
  const ContactForce& force = system.forces[pair.force_begin + p];
  into.impulse[lane] = static_cast<T>(per_newton * force.normal_n);
  set(Vec3(per_newton * force.friction_n), lane, into.friction_impulse);
}

}  // namespace

template <class T>
ScaledInverseInertia<T> scaled_inverse_inertia(const SolverBody& body, const Mat3& inverse_inertia) {
  ScaledInverseInertia<T> made;
  if (body.inverse_mass == 0) return made;
  const double kg = 1.0 / body.inverse_mass;
  const double parts[6] = {inverse_inertia(0, 0), inverse_inertia(1, 1), inverse_inertia(2, 2),
                           inverse_inertia(0, 1), inverse_inertia(0, 2), inverse_inertia(1, 2)};
  for (std::size_t k = 0; k < 6; ++k) made.inertia[k] = static_cast<T>(kg * parts[k]);
  return made;
}

template <class T>
void fill_block(const ContactSystem& system, const BlockTerms& terms, ContactBlock& block, PairLanes<T>& shared,
                Lanes<T>& lanes) {
  const std::span<PointLanes<T>> manifold_points = lanes.manifold_points_of(block);
  const std::span<const std::uint32_t> order = system.coloring.order().subspan(block.begin, block.count);
  if (block.count < kLanes) shared = {};
  std::ranges::fill(std::as_writable_bytes(std::span(shared.shift)), std::byte{0});
  std::ranges::fill(std::as_writable_bytes(manifold_points), std::byte{0});
  StartLanes<T> start;
  block.dynamic_a = block.dynamic_b = block.pushed = block.shifted = 0;
  block.frictional = false;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    // Lanes that are not in use read what nobody else writes, and write nothing.
    const std::uint32_t name = order[std::min<std::size_t>(lane, block.count - 1U)];
    const Manifold& pair = system.pairs[name];
    block.pair[lane] = name;
    block.a[lane] = pair.a;
    block.b[lane] = pair.b;
    if (lane >= block.count) continue;
    fill_pair(system, pair, lane, block, shared, start);
    const SolverBody& a = system.bodies[pair.a];
    const SolverBody& b = system.bodies[pair.b];
    // Without an external acceleration a warm start would add energy.
    const double per_newton = a.pulled || b.pulled ? terms.substep_s * (a.inverse_mass + b.inverse_mass) : 0.0;
    for (std::size_t p = 0; p < pair.point_count; ++p)
      fill_point(system, pair, per_newton, p, lane, manifold_points[p]);
  }
  prepare_block(block, shared, start, static_cast<T>(terms.still_mps), manifold_points,
                lanes.scaled_inverse_inertias.data());
}

template <class T>
void add_totals(const ContactBlock& block, bool first, Lanes<T>& lanes) {
  const std::span<const PointLanes<T>> manifold_points = lanes.manifold_points_of(block);
  const std::span<TotalLanes<T>> totals = lanes.totals_of(block);
  for (std::size_t p = 0; p < manifold_points.size(); ++p) {
    const PointLanes<T>& point = manifold_points[p];
    TotalLanes<T>& into = totals[p];
    if (first) into = {};
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t lane = 0; lane < kLanes; ++lane)
        into.total[k][lane] += point.impulse[lane] * point.normal[k][lane] + point.friction_impulse[k][lane];
    }
  }
}

// As add_late_impulses (angular_balance.h), of the last substep.
template <class T>
void add_late_impulse(double late_s, std::span<const PointLanes<T>> points, std::size_t lane, PairLanes<T>& shared) {
  for (const PointLanes<T>& point : points) {
    for (std::size_t k = 0; k < 3; ++k) {
      const T given = point.impulse[lane] * point.normal[k][lane] + point.friction_impulse[k][lane];
      shared.shift[k][lane] -= static_cast<T>(late_s) * given;
    }
  }
}

template <class T>
void write_back_block(const ContactSystem& system, const SubstepTimes& times, ContactBlock& block, PairLanes<T>& shared,
                      std::span<const PointLanes<T>> manifold_points, std::span<const TotalLanes<T>> totals) {
  const double still_square = times.still_mps * times.still_mps;
  for (std::size_t lane = 0; lane < block.count; ++lane) {
    const Manifold& pair = system.pairs[block.pair[lane]];
    const double unit_ns = static_cast<double>(shared.reduced_mass[lane]);
    const double unit_n = unit_ns / times.substep_s;
    // Number by number: vectors would be written in parts and read whole, which waits.
    double impulse[3] = {};
    double moment[3] = {};
    for (std::size_t p = 0; p < pair.point_count; ++p) {
      const PointLanes<T>& point = manifold_points[p];
      ContactForce& force = system.forces[pair.force_begin + p];
      force.normal_n = unit_n * static_cast<double>(point.impulse[lane]);
      double given[3];
      double arm[3];
      for (std::size_t k = 0; k < 3; ++k) {
        force.friction_n[static_cast<Eigen::Index>(k)] = unit_n * static_cast<double>(point.friction_impulse[k][lane]);
        given[k] = unit_ns * static_cast<double>(totals[p].total[k][lane]);
        arm[k] = static_cast<double>(point.arm[k][lane]);
        impulse[k] += given[k];
      }
      moment[0] += arm[1] * given[2] - arm[2] * given[1];
      moment[1] += arm[2] * given[0] - arm[0] * given[2];
      moment[2] += arm[0] * given[1] - arm[1] * given[0];
    }
    const Vec3 sum(impulse[0], impulse[1], impulse[2]);
    const Vec3 moment_a(moment[0], moment[1], moment[2]);
    const auto add_impulse = [&](double share, Vec3& into) {
      for (std::size_t k = 0; k < 3; ++k) into[static_cast<Eigen::Index>(k)] += share * impulse[k];
    };
    Vec3& applied_impulse_ns = system.applied_impulse_ns[block.pair[lane]];
    applied_impulse_ns.setZero();
    add_impulse(1, applied_impulse_ns);
    const bool pushed = (std::uint32_t{block.pushed} >> lane & 1U) != 0;
    if (!pushed && sum.isZero(0) && moment_a.isZero(0)) continue;
    SolverBody& a = system.bodies[pair.a];
    SolverBody& b = system.bodies[pair.b];
    // Where something pulls, angular momentum is not that of the bodies alone.
    const bool free = a.inverse_mass > 0 && b.inverse_mass > 0 && !a.pulled && !b.pulled;
    if (free && (b.velocity_mps - a.velocity_mps).squaredNorm() > still_square) {
      add_late_impulse(times.late_s, manifold_points.first(pair.point_count), lane, shared);
      block.shifted = static_cast<std::uint8_t>(block.shifted | 1U << lane);
    }
    if (a.inverse_mass > 0) {
      add_impulse(-a.inverse_mass, a.velocity_mps);
      a.spin_radps -= system.inverse_inertia[pair.a] * moment_a;
      a.solved = true;
    }
    if (b.inverse_mass > 0) {
      const Vec3 a_to_b = system.poses[pair.b].position_m - system.poses[pair.a].position_m;
      add_impulse(b.inverse_mass, b.velocity_mps);
      b.spin_radps += system.inverse_inertia[pair.b] * (moment_a - a_to_b.cross(sum));
      b.solved = true;
    }
  }
}

template ScaledInverseInertia<float> scaled_inverse_inertia(const SolverBody&, const Mat3&);
template ScaledInverseInertia<double> scaled_inverse_inertia(const SolverBody&, const Mat3&);
template void fill_block(const ContactSystem&, const BlockTerms&, ContactBlock&, PairLanes<float>&, Lanes<float>&);
template void fill_block(const ContactSystem&, const BlockTerms&, ContactBlock&, PairLanes<double>&, Lanes<double>&);
template void add_totals(const ContactBlock&, bool, Lanes<float>&);
template void add_totals(const ContactBlock&, bool, Lanes<double>&);
template void write_back_block(const ContactSystem&, const SubstepTimes&, ContactBlock&, PairLanes<float>&,
                               std::span<const PointLanes<float>>, std::span<const TotalLanes<float>>);
template void write_back_block(const ContactSystem&, const SubstepTimes&, ContactBlock&, PairLanes<double>&,
                               std::span<const PointLanes<double>>, std::span<const TotalLanes<double>>);

}  // namespace poise::solver
