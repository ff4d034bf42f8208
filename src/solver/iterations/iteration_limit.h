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

/// While bodies of like masses collide that have more contact points than this, iterations are plain ones and end when
/// most of the change is made (MeanChange): extrapolation gains nothing there. Chosen: up to here the limits above cost
/// 1.4 ms a substep at most.
inline constexpr std::uint64_t kFewPoints = 256;
/// Masses are alike up to this ratio. A heavy body on light ones changes little in each plain iteration although it is
/// far from the solution, so changes do not tell when these are enough. Chosen: with 32, heaps of meshes slip more.
inline constexpr double kLikeMasses = 4;

/// From the second one on these iterations are over-relaxed (Young 1954): below 2 each change still lowers the energy
/// that the contacts minimise. Chosen, like the next: docs/response.md, "Over-relaxed iterations".
inline constexpr double kCollisionRelaxation = 1.4;
/// Where impacts have told that bodies collide, and iterations are at most so many a substep, all of them are: by this
/// factor where not by the one above.
inline constexpr double kImpactRelaxation = 1.2;
inline constexpr std::uint32_t kFewIterations = 8;

/// Have the two bodies of each pair masses that are alike?
inline bool alike(const ContactSystem& system) {
  return std::ranges::all_of(system.pairs, [&](const Manifold& pair) {
    const double a = system.bodies[pair.a].inverse_mass;
    const double b = system.bodies[pair.b].inverse_mass;
    return a == 0 || b == 0 || std::max(a, b) <= kLikeMasses * std::min(a, b);
  });
}

/// Limits of the iterations of a substep.
struct IterationLimit {
  std::uint32_t most = 1;
  std::uint32_t hard = 1;        ///< while they are far from the solution
  bool mixed = false;            ///< extrapolated
  bool by_mean = false;          ///< none more once the mean over the contact points has settled
  bool only_collisions = false;  ///< abandoned after the first iteration where bodies do not collide
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
  // Without gravity nothing rests on anything, and still is no measure.
  const bool weighs = !settings.gravity_mps2.isZero(0);
  const bool by_mean = weighs && system.point_count > kFewPoints && plain > 1 && alike(system);
  if (sped_up < kMixedIterations) return {plain, plain, false, by_mean};
  const std::uint32_t most = std::min(sped_up, kMaxIterations);
  return {most, weighs ? std::min(sped_up, kMaxHardIterations) : most, true, by_mean};
}

/// Plain iterations for a step whose limit is `mixed`, where bodies collide. Not where there is one substep, which has
/// moved the bodies by then.
inline IterationLimit of_collisions(const IterationLimit& mixed) {
  return {kMixedIterations - 1, kMixedIterations - 1, false, mixed.by_mean, true};
}

/// The factor of the first iteration of a substep.
inline double first_relaxation(const ContactSystem& system, const SolveSettings& settings,
                               const IterationLimit& limit) {
  const bool relaxed = settings.collide && !limit.mixed && limit.most <= kFewIterations &&
                       !settings.stopping.converges() && system.point_count > kFewPoints &&
                       !settings.gravity_mps2.isZero(0);
  return relaxed ? kImpactRelaxation : 1;
}

}  // namespace poise::solver
