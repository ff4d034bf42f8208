// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "solver/anderson_mixing.h"

/// The sums of AndersonMixing over all numbers, in lanes. Each is summed in the order of the numbers, so its bits
/// depend on no instruction set.
namespace poise::solver {

/// Of each step, the products with one step and with the last residual.
struct StepProducts {
  std::array<double, AndersonMixing::kDepth> with_step{}, with_last{};
};

/// `steps` holds kDepth numbers for each of `last`: those of all steps. `step` is the index of one of them.
StepProducts step_products(std::span<const double> steps, std::span<const double> last, std::size_t step);

/// Takes from each number of `from` those of the steps, one step after another, times `parts`.
void subtract_steps(std::span<const double* const> steps, std::span<const double> parts, std::span<double> from);

}  // namespace poise::solver
