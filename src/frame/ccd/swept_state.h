// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/time_of_impact/conservative_advancement.h"

namespace poise::simulation {

/// A pair with a fast body, sent to backtracking.
struct SweptPair {
  std::uint32_t pair = 0;  ///< place in FrameBuffers::pairs
  double tolerance_m = 0;  ///< how near counts as touching
};

/// The way of a body through the step, as the response has left it.
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
  std::uint32_t pair = 0;       ///< place in FrameBuffers::pairs
  Vec3 normal = Vec3::UnitZ();  ///< from a to b
  Vec3 point_m = Vec3::Zero();
  double gap_m = 0;
  double impulse_ns = 0;  ///< that b received along the normal
};

/// Something that is about to happen; stale if the pair has been looked at again since.
struct SweptEvent {
  double time_s = 0;
  std::uint32_t pair = 0;  ///< place in SweptFrame::pairs
  std::uint32_t look = 0;
};

/// What backtracking works on in one frame. Empty and untouched in Worlds that never ask for it. Invariant: buffers
/// only grow.
struct SweptFrame {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  bool on = false;
  std::vector<collision::SweptBound> bounds;  // of fast bodies, in order of slots
  std::vector<std::uint32_t> bound_of;        // per slot, kNone for slow ones
  std::vector<SweptPair> pairs;               // in canonical order
  std::vector<double> limit_s;                // per slot: when the body must stop whatever it meets
  std::vector<Trajectory> trajectories;
  std::vector<std::uint32_t> trajectory_of;  // per slot, kNone for bodies that are in no swept pair and not stopped
  std::vector<std::uint32_t> pairs_begin, pairs_of;      // per course: its pairs
  std::vector<collision::TimeOfImpact> times_of_impact;  // one a pair
  std::vector<std::uint32_t> looks;                      // one a pair
  std::vector<SweptEvent> queue;                         // a heap, the earliest in front
  std::vector<SweptHit> hits;                            // in order of time

  [[nodiscard]] bool fast(std::uint32_t slot) const { return bound_of[slot] != kNone; }
};

}  // namespace poise::simulation
