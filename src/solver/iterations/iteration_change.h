// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "solver/contacts/contact_lanes.h"
#include "solver/contacts/split_system.h"
#include "solver/iterations/iteration_limit.h"

/// The iterations of a substep: what one of them has changed, and whether another one is worth it.
namespace poise::solver {

/// How the iterations of one substep are done.
template <class T>
struct Iterating {
  const SplitSystem& system;
  const SolveSettings& settings;
  const IterationLimit& limit;
  const SubstepTerms<T>& terms;
};

/// How they ended.
struct Iterated {
  bool reached = false;  ///< the share of change that was asked for
  bool settled = false;
  bool far = true;         ///< from still
  bool collision = false;  ///< bodies collide
  bool stopped = false;    ///< there was no time for more
};

template <class T>
IterationChange<double> widened(const IterationChange<T>& change) {
  return {static_cast<double>(change.largest_ns), static_cast<double>(change.change_ns),
          static_cast<double>(change.change_mps), static_cast<double>(change.impulse_sum_ns),
          static_cast<double>(change.residual_j)};
}

/// Of all blocks: the largest of what is a measure of one, and the sums of the rest, block after block.
inline IterationChange<double> sum_of(const std::vector<IterationChange<double>>& changes) {
  IterationChange<double> sum;
  for (const IterationChange<double>& change : changes) {
    sum.largest_ns = std::max(sum.largest_ns, change.largest_ns);
    sum.change_ns = std::max(sum.change_ns, change.change_ns);
    sum.change_mps = std::max(sum.change_mps, change.change_mps);
    sum.impulse_sum_ns += change.impulse_sum_ns;
    sum.residual_j += change.residual_j;
  }
  return sum;
}

/// The mean change of approach speeds in an iteration, weighted by impulses: whether another one is worth it.
class MeanChange {
 public:
  /// After each iteration of a substep. `still_mps` as solver::still_mps.
  void add(double change_mps, double still_mps) {
    if (first_mps_ < 0) {
      first_mps_ = change_mps;
      collides_ = change_mps > still_mps;
    }
    settled_ = collides_ && change_mps <= kSettledOfFirst * first_mps_;
  }
  /// The first iteration has changed more than gravity does in a step: bodies collide.
  [[nodiscard]] bool collides() const { return collides_; }
  /// They do, and it is done but for a small share.
  [[nodiscard]] bool settled() const { return settled_; }

 private:
  // Chosen: the error of 500 jacks while they land is that of extrapolation to the end, with 0.2 it is 7 % larger, with
  // 0.5 57 % (docs/response.md, "Iterations of collisions").
  static constexpr double kSettledOfFirst = 0.05;
  double first_mps_ = -1;
  bool collides_ = false, settled_ = false;
};

}  // namespace poise::solver
