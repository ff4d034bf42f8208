// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/front/pair_refinement.h"
#include "collision/time_of_impact/conservative_advancement.h"
#include "frame/pair_progress.h"

/// What backtracking adds to the outputs of the stages. Empty and untouched in Worlds that never ask for it. Invariant:
/// buffers only grow.
namespace poise::simulation {

/// Of *predict*: the bodies that move far in the step.
struct SweptBounds {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  bool on = false;
  std::vector<collision::SweptBound> bounds;  ///< of fast bodies, in order of slots
  std::vector<std::uint32_t> bound_of;        ///< per slot, kNone for slow ones

  [[nodiscard]] bool fast(std::uint32_t slot) const { return on && bound_of[slot] != kNone; }
};

/// Of *coarse*: a pair with a fast body, taken out of refinement.
struct SweptPair {
  std::uint32_t pair = 0;           ///< index into PairTable::pairs
  double tolerance_m = 0;           ///< how near counts as touching
  PairProgress progress;            ///< in place of what its PairStart says
  collision::LevelContact contact;  ///< where the two touch at the start of the step
};

/// The trajectory of a body through the step, as the solver has left it.
struct Trajectory {
  std::uint32_t slot = 0;
  bool dynamic = false;
  bool stopped = false;  ///< before the end of the step
  double stop_s = 0;     ///< from here on it stands
  collision::MovingBody start;
  collision::MovingBody stands;      ///< where, once stopped; the spin is that with which it leaves the step
  Vec3 velocity_mps = Vec3::Zero();  ///< likewise
};

/// A pair that met within the step.
struct SweptHit {
  std::uint32_t pair = 0;       ///< index into PairTable::pairs
  Vec3 normal = Vec3::UnitZ();  ///< from a to b
  Vec3 point_m = Vec3::Zero();
  double gap_m = 0;
  Vec3 impulse_ns = Vec3::Zero();  ///< that b received
};

/// A time of impact in the queue; stale if that of the pair has been computed again since.
struct SweptEvent {
  double time_s = 0;
  std::uint32_t pair = 0;  ///< index into PairTable::swept
  std::uint32_t look = 0;
};

/// Of *solve*: what met within the step.
struct SweptContacts {
  static constexpr std::uint32_t kNone = SweptBounds::kNone;
  std::vector<double> limit_s;  ///< per slot: when the body must stop whatever it meets
  std::vector<Trajectory> trajectories;
  std::vector<std::uint32_t> trajectory_of;  ///< per slot, kNone for bodies in no swept pair that are not stopped
  std::vector<SweptHit> hits;                ///< in order of time

  std::vector<std::uint32_t> pairs_begin, pairs_of;      // scratch, per trajectory: its pairs
  std::vector<collision::TimeOfImpact> times_of_impact;  // scratch, one a swept pair
  std::vector<std::uint32_t> looks;                      // scratch, one a swept pair: how often it was computed
  std::vector<SweptEvent> queue;                         // scratch: a heap, the earliest in front

  /// The trajectory of a body that was stopped before the end of the step, or null.
  [[nodiscard]] const Trajectory* stopped(std::uint32_t slot) const {
    if (trajectories.empty() || trajectory_of[slot] == kNone) return nullptr;
    const Trajectory& trajectory = trajectories[trajectory_of[slot]];
    return trajectory.stopped ? &trajectory : nullptr;
  }
};

}  // namespace poise::simulation
