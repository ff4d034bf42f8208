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
/// later frames whose bounds are inside those. Of the few that leave theirs the pairs are looked for one by one. They
/// may hold more; who asks for pairs of the frame's own bounds looks at each. How they are found depends on the bounds
/// alone, so results do on neither threads nor timing. Invariant: buffers only grow.
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
    bool same = false;     ///< the same bodies, each in the same groups
    std::size_t left = 0;  ///< how many are not inside their cached bounds
    bool calm = false;     ///< few have moved much since these were cached
  };
  // Lists those that have left in left_, if these are few.
  Look look(std::span<const collision::MotionBound> bounds, std::span<const collision::PlaneBound> planes,
            parallel::Executor& executor);
  void keep(const collision::MotionBound& bound, std::size_t i);

  parallel::UnsetVector<collision::MotionBound> bounds_;  // larger than asked for, if wide_
  std::vector<collision::PlaneBound> planes_;
  parallel::UnsetVector<double> radius_m_;  // as asked for
  collision::BroadPhase::Result found_;
  std::vector<std::uint32_t> left_;
  std::uint64_t resting_version_ = 0;  // of the grid of resting bounds
  bool wide_ = false;
};

}  // namespace poise::simulation
