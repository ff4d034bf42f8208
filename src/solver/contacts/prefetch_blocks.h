// SPDX-License-Identifier: MIT
#pragma once

#include "parallel/prefetch.h"
#include "solver/contacts/contact_lanes.h"
#include "solver/contacts/split_system.h"

/// Prefetches what a block's pairs need, some blocks ahead: pairs of one colour lie far apart in memory.
namespace poise::solver {

/// The pairs themselves, which the others look at.
HWY_INLINE void prefetch_pairs(const SplitSystem& system, const ContactBlock& block) {
  for (const std::uint32_t name : system.coloring.order().subspan(block.begin, block.count))
    parallel::prefetch(system.pairs[name]);
}

HWY_INLINE void prefetch_forces(const SplitSystem& system, const Manifold& pair) {
  parallel::prefetch(system.forces[pair.point_begin]);
  parallel::prefetch(system.forces[pair.point_begin + pair.point_count - 1U]);
}

/// What fill_block reads.
HWY_INLINE void prefetch_points(const SplitSystem& system, const ContactBlock& block) {
  for (const std::uint32_t name : system.coloring.order().subspan(block.begin, block.count)) {
    const Manifold& pair = system.pairs[name];
    if (system.solved_points(name) == 0) continue;
    for (std::size_t p = 0; p < pair.point_count; ++p) parallel::prefetch(system.points[pair.point_begin + p]);
    prefetch_forces(system, pair);
    for (const std::uint32_t body : {pair.a, pair.b}) {
      hwy::Prefetch(&system.bodies[body]);
      parallel::prefetch(system.poses[body]);
    }
  }
}

/// What write_back_block reads and writes.
HWY_INLINE void prefetch_results(const SplitSystem& system, const ContactBlock& block) {
  for (std::size_t lane = 0; lane < block.count; ++lane) {
    const Manifold& pair = system.pairs[block.pair[lane]];
    if (system.solved_points(block.pair[lane]) == 0) continue;
    prefetch_forces(system, pair);
    parallel::prefetch(system.applied_impulse_ns[block.pair[lane]]);
    for (const std::uint32_t body : {pair.a, pair.b}) {
      hwy::Prefetch(&system.bodies[body]);
      hwy::Prefetch(&system.poses[body]);
      parallel::prefetch(system.inverse_inertia[body]);
    }
  }
}

/// What solve_block reads and writes of the bodies.
template <class T>
HWY_INLINE void prefetch_motions(const BodyLanes<T>& bodies, const ContactBlock& block) {
  for (std::size_t lane = 0; lane < block.count; ++lane) {
    for (const std::uint32_t body : {block.a[lane], block.b[lane]}) {
      parallel::prefetch(bodies.motions[body]);
      hwy::Prefetch(&bodies.scaled_inverse_inertias[body]);
    }
  }
}

}  // namespace poise::solver
