// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "poise/types.h"
#include "solver/impacts/impact_row.h"

namespace poise::solver {

/// Rows, or contact points of rows, that are looked at or answer side by side. Different rows that answer share no
/// dynamic body.
struct ImpactBatch {
  static constexpr std::size_t kRows = 64;
  std::uint32_t row[kRows], a[kRows], b[kRows];  ///< each row, or contact point, and its bodies
  alignas(64) double lambda_ns[kRows];           ///< the impulse along its wrench; 0 for none
  // Out, a bit by place:
  std::uint64_t needs = 0;             ///< there is an impulse
  std::uint64_t rebounds = 0;          ///< it closes fast enough to rebound
  std::uint64_t overlaps_rebound = 0;  ///< an overlapping point of it might
  std::size_t count = 0;

  static_assert(kRows <= 64);

  void add(std::uint32_t index, std::uint32_t body_a, std::uint32_t body_b) {
    row[count] = index;
    a[count] = body_a;
    b[count] = body_b;
    ++count;
  }
};

/// What they work on.
struct ImpactLanes {
  ContactRow* rows = nullptr;
  const OverlapPoint* overlaps = nullptr;
  SolverBody* bodies = nullptr;
  const Mat3* inverse_inertia = nullptr;  ///< one a body, world frame
  double dt_s = 0;
  double still_mps = 0;  ///< what closes more slowly is at rest
};

/// Sets lambda_ns and the bits of a batch of rows.
void look_at_rows(const ImpactLanes& lanes, ImpactBatch& batch);

/// Sets the bits `rebounds` of a batch of contact points that certainly penetrate.
void look_at_overlaps(const ImpactLanes& lanes, ImpactBatch& batch);

/// Applies lambda_ns to the bodies of a batch, and friction with it. Adds what friction gives to point_impulse_ns of
/// the rows.
void give_impulses(const ImpactLanes& lanes, ImpactBatch& batch);

}  // namespace poise::solver
