// SPDX-License-Identifier: MIT
#include "solver/contacts/contact_blocks.h"

#include <algorithm>
#include <cstddef>

#include "solver/contacts/fill_lanes.h"

namespace poise::solver {
namespace {

// What the lanes of a block are filled from; names its pairs and bodies in it.
void gather_sources(const SplitSystem& system, double substep_s, ContactBlock& block, LaneSources& sources) {
  static const Manifold no_pair;
  static const SolverBody nothing;
  static const collision::Pose nowhere;
  const std::span<const std::uint32_t> order = system.coloring.order().subspan(block.begin, block.count);
  block.dynamic_a = block.dynamic_b = block.pushed = block.shifted = 0;
  block.frictional = false;
  sources.warm = 0;
  sources.least_points = 0xff;
  sources.substep_s = substep_s;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    // Lanes that are not in use read what nobody else writes, and write nothing.
    const bool used = lane < block.count;
    const std::uint32_t name = order[used ? lane : block.count - 1U];
    const Manifold& pair = system.pairs[name];
    const RowEnds ends = system.ends_of(name);
    const SolverBody& a = used ? system.body(ends.a) : nothing;
    const SolverBody& b = used ? system.body(ends.b) : nothing;
    block.pair[lane] = name;
    block.a[lane] = ends.a;
    block.b[lane] = ends.b;
    sources.a[lane] = &a;
    sources.b[lane] = &b;
    sources.pose_a[lane] = used ? &system.poses[pair.a] : &nowhere;
    sources.pose_b[lane] = used ? &system.poses[pair.b] : &nowhere;
    sources.points[lane] = system.points.data() + pair.point_begin;
    sources.forces[lane] = system.forces.data() + pair.point_begin;
    sources.point_count[lane] = used ? system.solved_points(name) : std::uint8_t{0};
    sources.least_points = std::min(sources.least_points, sources.point_count[lane]);
    sources.pairs[lane] = used ? &pair : &no_pair;
    // Without an external acceleration a warm start would add energy.
    if (a.pulled || b.pulled) sources.warm = static_cast<std::uint8_t>(sources.warm | 1U << lane);
    if (a.inverse_mass > 0) block.dynamic_a = static_cast<std::uint8_t>(block.dynamic_a | 1U << lane);
    if (b.inverse_mass > 0) block.dynamic_b = static_cast<std::uint8_t>(block.dynamic_b | 1U << lane);
    block.frictional = block.frictional || (used && pair.friction > 0);
  }
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
void fill_block(const SplitSystem& system, const BlockTerms& terms, ContactBlock& block, PairLanes<T>& shared,
                Lanes<T>& lanes) {
  const std::span<PointLanes<T>> manifold_points = lanes.manifold_points_of(block);
  LaneSources sources;
  StartLanes<T> start;
  gather_sources(system, terms.substep_s, block, sources);
  fill_lanes(sources, shared, start, manifold_points);
  prepare_block(block, shared, start, terms, manifold_points, lanes.scaled_inverse_inertias.data());
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
void write_back_block(const SplitSystem& system, const SubstepTimes& times, ContactBlock& block, PairLanes<T>& shared,
                      std::span<const PointLanes<T>> manifold_points, std::span<const TotalLanes<T>> totals) {
  const double still_square = times.still_mps * times.still_mps;
  LaneForces forces;
  forces.lanes = block.count;
  forces.substep_s = times.substep_s;
  for (std::size_t lane = 0; lane < block.count; ++lane) {
    const Manifold& pair = system.pairs[block.pair[lane]];
    forces.first[lane] = system.forces.data() + pair.point_begin;
    forces.point_count[lane] = system.solved_points(block.pair[lane]);
  }
  LaneImpulses impulses;
  collect_lanes(shared, manifold_points, totals, forces, impulses);
  for (std::size_t lane = 0; lane < block.count; ++lane) {
    // Read where they are: copies that were just written number by number are waited for where they are read in pairs.
    const Eigen::Map<const Vec3> sum(impulses.impulse_ns[lane]);
    const Eigen::Map<const Vec3> moment_a(impulses.moment_a_nms[lane]);
    system.applied_impulse_ns[block.pair[lane]] = sum;
    const bool pushed = (std::uint32_t{block.pushed} >> lane & 1U) != 0;
    if (!pushed && sum.isZero(0) && moment_a.isZero(0)) continue;
    SolverBody& a = system.body(block.a[lane]);
    SolverBody& b = system.body(block.b[lane]);
    // Where something pulls, angular momentum is not that of the bodies alone.
    const bool free = a.inverse_mass > 0 && b.inverse_mass > 0 && !a.pulled && !b.pulled;
    if (free && (b.velocity_mps - a.velocity_mps).squaredNorm() > still_square) {
      add_late_impulse(times.late_s, manifold_points.first(forces.point_count[lane]), lane, shared);
      block.shifted = static_cast<std::uint8_t>(block.shifted | 1U << lane);
    }
    if (a.inverse_mass > 0) {
      a.velocity_mps -= a.inverse_mass * sum;
      a.spin_radps.noalias() -= system.inverse_inertia_of(block.a[lane]) * moment_a;
      a.solved = true;
    }
    if (b.inverse_mass > 0) {
      const Vec3 a_to_b = system.pose_of(block.b[lane]).position_m - system.pose_of(block.a[lane]).position_m;
      b.velocity_mps += b.inverse_mass * sum;
      const Vec3 moment_b(moment_a.x() - (a_to_b.y() * sum.z() - a_to_b.z() * sum.y()),
                          moment_a.y() - (a_to_b.z() * sum.x() - a_to_b.x() * sum.z()),
                          moment_a.z() - (a_to_b.x() * sum.y() - a_to_b.y() * sum.x()));
      b.spin_radps.noalias() += system.inverse_inertia_of(block.b[lane]) * moment_b;
      b.solved = true;
    }
  }
}

template ScaledInverseInertia<float> scaled_inverse_inertia(const SolverBody&, const Mat3&);
template ScaledInverseInertia<double> scaled_inverse_inertia(const SolverBody&, const Mat3&);
template void fill_block(const SplitSystem&, const BlockTerms&, ContactBlock&, PairLanes<float>&, Lanes<float>&);
template void fill_block(const SplitSystem&, const BlockTerms&, ContactBlock&, PairLanes<double>&, Lanes<double>&);
template void add_totals(const ContactBlock&, bool, Lanes<float>&);
template void add_totals(const ContactBlock&, bool, Lanes<double>&);
template void write_back_block(const SplitSystem&, const SubstepTimes&, ContactBlock&, PairLanes<float>&,
                               std::span<const PointLanes<float>>, std::span<const TotalLanes<float>>);
template void write_back_block(const SplitSystem&, const SubstepTimes&, ContactBlock&, PairLanes<double>&,
                               std::span<const PointLanes<double>>, std::span<const TotalLanes<double>>);

}  // namespace poise::solver
