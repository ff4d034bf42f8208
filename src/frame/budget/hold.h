// SPDX-License-Identifier: MIT
#pragma once

#include "frame/budget/islands.h"

/// Islands that wait: a frame that has no time for all of them leaves some as they are, and has their time for
/// refinement. What waits runs slower than the rest. A hook of *refine*, before its first level.
namespace poise::simulation {

/// Holds islands that may wait (budget/islands.h) until `contacts` pairs need no response, or all that may be held are.
/// Returns how many bodies are held. Islands without contacts are not. Held bodies keep position and velocity, and
/// their pairs are refined like others, but have no response and no contact in this frame.
std::size_t hold_islands(const RefineInput& input, std::uint64_t contacts, CompletedLevels& levels,
                         parallel::Executor& executor);

/// The same for islands by their roots, ascending, as another run of this step held them. False if one is not an island
/// or may not be held.
bool hold_as_recorded(const RefineInput& input, std::span<const std::uint32_t> roots, CompletedLevels& levels,
                      Degraded& degraded, parallel::Executor& executor);

}  // namespace poise::simulation
