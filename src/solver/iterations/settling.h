// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solver/contacts/contact_lanes.h"
#include "solver/contacts/split_system.h"

namespace poise::solver {

/// Whether the velocities of an iteration that converges are still on their way. Where contacts carry more than they
/// need to, impulses go on changing for long while no body notices; and where a heap hangs together, each iteration
/// changes little and all of them together much. So the velocities after n iterations are compared with those after
/// n / 2. Invariant: buffers only grow.
class Settling {
 public:
  /// Iterations before the first comparison is prepared. Chosen: with fewer, heaps at rest seem to have settled before
  /// anything has come from one end of them to the other.
  static constexpr std::uint32_t kFirst = 1024;

  /// Before the first iteration of a substep.
  void begin() { half_.clear(); }
  /// After each of them, with the velocities `now`, and `begun` before forces and contacts acted. True where n is due,
  /// and the mean square of what the second half of the iterations changed is at most share^2 times that of all that
  /// the contacts change. A spin counts with the mean inertia, as in the error of a body.
  bool settled(const SplitSystem& system, std::span<const MotionChange<double>> now,
               std::span<const SpeedChange<double>> begun, double h_s, std::uint32_t iterations, double share);

 private:
  std::vector<MotionChange<double>> half_;  // velocities after half of the iterations
};

}  // namespace poise::solver
