// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace poise::solver {

/// Speeds up the repetition of a map x -> g(x) that approaches a fixed point (Anderson 1965; Walker and Ni 2011, type
/// II): the next point is that combination of the last few whose residuals g(x) - x cancel best. Starts anew when the
/// residual grows. Invariant: buffers only grow.
class AndersonMixing {
 public:
  static constexpr std::size_t kDepth = 8;

  void begin(std::size_t size);
  /// `before` is x, `after` is g(x) and becomes the next x. False: it stays g(x).
  bool mix(std::span<const double> before, std::span<double> after);

 private:
  std::size_t size_ = 0;
  std::size_t count_ = 0;  // steps stored, the newest at (next_ - 1) % kDepth
  std::size_t next_ = 0;
  bool started_ = false;
  double last_square_ = 0;
  // Differences of each step to the point before. Those of residuals stand side by side, number by number, so that the
  // products with all steps are summed at once.
  std::vector<double> residual_steps_;
  std::array<std::vector<double>, kDepth> after_steps_;
  std::array<std::array<double, kDepth>, kDepth> products_{};  // of the residuals of two steps, by their indices
  std::vector<double> residual_, after_;                       // of the last point
};

}  // namespace poise::solver
