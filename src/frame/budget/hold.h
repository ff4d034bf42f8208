// SPDX-License-Identifier: MIT
#pragma once

#include "frame/refine/refine.h"

/// Islands that wait: a frame that has no time for all of them leaves some as they are, and has their time for
/// refinement. What waits runs slower than the rest. A hook of *refine*, before its first level.
namespace poise::simulation {

/// A body is stepped at least in every eighth frame. Chosen: time enough to refine a heap of thousands as a whole.
inline constexpr std::uint8_t kMostFramesHeld = 7;

/// Holds islands until `contacts` pairs need no response, or all that may be held are: those near rest first, then the
/// others if input.islands_wait says so, of both the least seen first. Returns how many bodies are held. An island is
/// what the frame's pairs connect, static bodies aside. It is near rest if no body is faster (|v| or R |w|) than
/// gravity makes it in 32 steps, one in ten at most faster than in 8, and half of them at most faster than in 2. Not
/// held are islands without contacts, with a body that the caller pushes, that meets a moving kinematic one, or that
/// has been held in the last kMostFramesHeld frames; and none at all without gravity or with backtracking. Held bodies
/// keep position and velocity, and their pairs are refined like others, but have no response and no contact in this
/// frame.
std::size_t hold_islands(const RefineInput& input, std::uint64_t contacts, CompletedLevels& levels,
                         parallel::Executor& executor);

/// The same for islands by their roots (the lowest slot of each), ascending, as another run of this step held them.
/// False if one is not an island or may not be held.
bool hold_as_recorded(const RefineInput& input, std::span<const std::uint32_t> roots, CompletedLevels& levels,
                      Degraded& degraded, parallel::Executor& executor);

}  // namespace poise::simulation
