// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "solver/contact_lanes.h"
#include "solver/iteration_limit.h"

/// What an iteration of the contact solver has changed, and whether another one is worth it.
namespace poise::solver {

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

/// The mean change of approach speeds in an iteration, weighted by impulses: whether more iterations are worth it.
class MeanChange {
 public:
  /// After each iteration of a substep. `still_mps` as solver::still_mps.
  void add(double change_mps, double still_mps) {
    if (rounds_ == 0) {
      first_mps_ = last_mps_ = change_mps;
      resting_ = change_mps <= kRestOfStill * still_mps;
    }
    const bool far = change_mps > kFarOfStill * still_mps;
    const bool slow = rounds_ > 0 && change_mps >= kSlow * last_mps_;
    settled_ =
        change_mps <= kSettledOfStill * still_mps || change_mps <= kSettledOfFirst * first_mps_ || (slow && !far);
    ++rounds_;
    stalled_ = resting_ && !settled_ && rounds_ >= kTrialIterations;
    last_mps_ = change_mps;
  }
  [[nodiscard]] bool settled() const { return settled_; }
  /// Bodies at rest have not settled by now: plain iterations are too few.
  [[nodiscard]] bool stalled() const { return stalled_; }

 private:
  // Chosen from runs of heaps that fall and that rest (docs/response.md, "Iterations").
  static constexpr double kSettledOfStill = 3e-4;
  static constexpr double kSettledOfFirst = 0.05;
  static constexpr double kSlow = 0.98;
  static constexpr double kFarOfStill = 0.01;
  static constexpr double kRestOfStill = 0.1;
  static constexpr std::uint32_t kTrialIterations = 6;
  double first_mps_ = 0, last_mps_ = 0;
  std::uint32_t rounds_ = 0;
  bool resting_ = false, settled_ = false, stalled_ = false;
};

}  // namespace poise::solver
