// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "poise/decisions.h"

namespace poise::app {

/// Work of one frame in node-pair expansions, against that of a queue that is sorted by score at all times.
struct OrderFigures {
  std::uint64_t full = 0;       ///< of all levels of all pairs
  std::uint64_t done = 0;       ///< of the levels that the frame has completed
  std::uint64_t misplaced = 0;  ///< of these, what a sorted queue would have left out with as much work
};

/// Compares what a frame has completed with a queue that always takes the level with the highest score, one at a time,
/// and ends when it has done as much work. `all` explains the same frame with every level of every pair, with the
/// scores that they have when their turn comes. Levels that were begun and discarded are not counted.
OrderFigures order_figures(const FrameDecisions& done, const FrameExplanation& all);

}  // namespace poise::app
