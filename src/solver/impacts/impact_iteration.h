// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>

#include "solver/solver.h"

namespace poise::solver {

/// Calls solve(step, begin, end) for the rows of each colour of the first set, at most `most` at a time, colour after
/// colour: in parallel within a colour, whose rows share no dynamic body. The order is that of the rows, so the result
/// does not depend on threads. Steps are these colours; what shares bodies is one more.
template <class Solve>
void for_each_run(const System& system, std::size_t most, parallel::Executor& executor, Solve&& solve) {
  const std::uint32_t colors = system.coloring.own_colors();
  for (std::uint32_t color = 0; color < colors; ++color) {
    const std::size_t first = system.coloring.begin(color);
    const std::size_t count = system.coloring.begin(color + 1) - first;
    parallel::parallel_for(executor, count, most,
                           [&](std::size_t begin, std::size_t end, int) { solve(color, first + begin, first + end); });
  }
}

/// True if the last iteration changed no impulse by more than the share of the largest one that `stopping` allows.
/// `impulse_ns` says which impulse of a row is meant.
inline bool settled(const System& system, const Stopping& stopping, double ContactRow::*impulse_ns) {
  double largest_ns = 0;
  double change_ns = 0;
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    if (!system.scratch.activations[i].ready) continue;
    largest_ns = std::max(largest_ns, system.rows[i].*impulse_ns);
    change_ns = std::max(change_ns, std::abs(system.scratch.change_ns[i]));
  }
  return change_ns <= stopping.share * largest_ns;
}

}  // namespace poise::solver
