// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>

#include "solver/contact_solver.h"

namespace poise::solver {

/// Iterations of a substep: limited by the number of point iterations, at least one, and none more once they have
/// settled. So small scenes converge, and the cost of large ones is linear in their contact points.
inline constexpr std::uint32_t kMaxIterations = 60;
/// Likewise while contact points, weighted by their impulses, are far from the solution: heavy bodies on light ones.
inline constexpr std::uint32_t kMaxHardIterations = 600;
/// Where point_iterations make so many iterations, they are extrapolated, in double precision: heavy bodies on light
/// ones need thousands of plain ones. Plain ones in single precision are fewer than that.
inline constexpr std::uint32_t kMixedIterations = 20;

/// Limits of the iterations of a substep.
struct IterationLimit {
  std::uint32_t most = 1;
  std::uint32_t hard = 1;  ///< while they are far from the solution
  bool mixed = false;      ///< extrapolated
  [[nodiscard]] std::uint32_t iterations(bool far) const { return far ? hard : most; }
};

/// With so many point_iterations of a substep, at their cost.
inline IterationLimit limit_of(const ContactSystem& system, const SolveSettings& settings,
                               std::uint32_t point_iterations) {
  const Stopping& stopping = settings.stopping;
  if (stopping.converges()) return {stopping.max_iterations, stopping.max_iterations, false};
  const std::uint32_t points = std::max(static_cast<std::uint32_t>(system.point_count), 1U);
  const std::uint32_t sped_up = std::min(point_iterations / kMixedIterationCost, kMixedPointIterations) / points;
  const std::uint32_t plain =
      std::clamp(std::min(point_iterations, kPlainPointIterations) / points, 1U, kMixedIterations - 1);
  if (sped_up < kMixedIterations) return {plain, plain, false};
  const std::uint32_t most = std::min(sped_up, kMaxIterations);
  // Without gravity nothing rests on anything, and still is no measure.
  const bool weighs = !settings.gravity_mps2.isZero(0);
  return {most, weighs ? std::min(sped_up, kMaxHardIterations) : most, true};
}

}  // namespace poise::solver
