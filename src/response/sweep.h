// SPDX-License-Identifier: MIT
#pragma once

#include "response/solve.h"

namespace poise::response {

/// Calls solve(i) for the place of every row, colour after colour: in parallel within a colour, whose rows share no
/// yielding body, and one after another where no colour was free. The order is that of the rows, so threads do not show.
template <class Solve>
void sweep(const System& system, parallel::Executor& executor, Solve&& solve) {
  constexpr std::size_t kGrain = 128;
  for (std::uint32_t color = 0; color < system.coloring.colors(); ++color) {
    const std::size_t first = system.coloring.begin(color);
    const std::size_t count = system.coloring.begin(color + 1) - first;
    parallel::parallel_for(executor, count, kGrain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = first + begin; i < first + end; ++i) solve(i);
    });
  }
  for (std::size_t i = system.coloring.serial_begin(); i < system.rows.size(); ++i) solve(i);
}

}  // namespace poise::response
