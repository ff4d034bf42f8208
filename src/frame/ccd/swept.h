// SPDX-License-Identifier: MIT
#pragma once

#include "frame/world_state.h"

/// Backtracking (docs/response.md): pairs with a body that moves far in a step are answered where and when they meet
/// within it. All of this is called only in steps with StepInput::backtracking, from the stages, by the thread that
/// steps.
namespace poise::simulation {

/// Before predict lists the bounds of bodies; in the first step without backtracking after one with it, forgets that
/// one.
void begin_swept(WorldState& world, const StepInput& input);

/// Is the body in this slot fast, that is, does it move farther in the step than half its least extent? Then it has its
/// swept bound now.
bool sweep_if_fast(WorldState& world, std::uint32_t slot, const StepInput& input);

/// Takes the pairs with a fast body out of refinement. Those that touch already make a row, by the exact contact of a
/// ball or else by their deepest level; those that overlap stay ordinary pairs, with their skin for a margin; all
/// others wait for answer_swept.
void send_swept(WorldState& world, const StepInput& input, FrameReport& report);

/// After the solvers: finds what meets on the ways that bodies are about to go, answers it in order of time (ties in
/// canonical order) by one impulse each, and has bodies that were hit stand where they were hit until the end of the
/// step. A body whose way is not the one that was swept stops before it leaves what was.
void solve_swept(WorldState& world, const StepInput& input, FrameReport& report);

/// Puts a body that was stopped where it stands, with its new velocities; false where it was not stopped.
bool place_stopped(WorldState& world, std::uint32_t slot);

}  // namespace poise::simulation
