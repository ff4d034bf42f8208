// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "solver/iterations/anderson_mixing.h"

/// The sums of AndersonMixing over all numbers, in lanes. Each is summed in the order of the numbers, so its bits
/// depend on no instruction set.
namespace poise::solver {

/// What a step is noted in, as many numbers each as the points have.
struct StepLists {
  std::span<double> residual, after;  ///< of the last point; afterwards of this one
  std::span<double> residual_steps;   ///< kDepth for each number: those of all steps
  std::span<double> after_step;       ///< of this step
};

/// A step that was noted.
struct NotedStep {
  double residual_square = 0;  ///< of this point
  /// Of the residual of each step, the products with that of this step, and with the residual of this point.
  std::array<double, AndersonMixing::kDepth> with_step{}, with_last{};
};

/// Notes the step from the last point to this one as that with the index `step`.
NotedStep note_step(std::span<const double> before, std::span<const double> after, std::size_t step,
                    const StepLists& lists);

/// Takes from each number of `from` those of the steps, one step after another, times `parts`.
void subtract_steps(std::span<const double* const> steps, std::span<const double> parts, std::span<double> from);

}  // namespace poise::solver
