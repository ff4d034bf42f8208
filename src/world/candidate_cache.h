// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collision/broad_phase/broad_phase.h"
#include "collision/broad_phase/resting_grid.h"
#include "parallel/executor.h"

namespace poise::simulation {

/// Candidate pairs that outlive a frame: found once with bounds a little larger than needed, they hold all pairs of
/// later frames whose bounds are inside those. They may hold more; who asks for pairs of the frame's own bounds looks
/// at each. Whether they are found anew depends on the bounds alone, so results do on neither threads nor timing.
/// Invariant: buffers only grow.
class CandidateCache {
 public:
  /// As BroadPhase::find, but for pairs too many. With swept bounds nothing is cached.
  collision::BroadPhase::Result find(collision::BroadPhase& broad_phase, std::span<const collision::MotionBound> bounds,
                                     std::span<const collision::PlaneBound> planes,
                                     std::span<const collision::SweptBound> swept,
                                     const collision::RestingGrid& resting, const collision::PartnerLimits& limits,
                                     parallel::Executor& executor);

 private:
  struct Look {
    bool inside = false;  ///< every bound is inside the cached one
    bool calm = false;    ///< few have moved much since these were cached
  };
  Look look(std::span<const collision::MotionBound> bounds, std::span<const collision::PlaneBound> planes,
            parallel::Executor& executor) const;

  parallel::UnsetVector<collision::MotionBound> bounds_;  // larger than asked for, if wide_
  std::vector<collision::PlaneBound> planes_;
  parallel::UnsetVector<double> radius_m_;  // as asked for
  collision::BroadPhase::Result found_;
  std::uint64_t resting_version_ = 0;  // of the grid of resting bounds
  bool wide_ = false;
};

}  // namespace poise::simulation
