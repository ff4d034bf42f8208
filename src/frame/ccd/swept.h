// SPDX-License-Identifier: MIT
#pragma once

#include "frame/coarse.h"
#include "frame/solve.h"

/// Backtracking (docs/backtracking.md): pairs with a body that moves far in a step are solved where and when they meet
/// within it. Each function is a hook of the stage that it names, called only with StepTerms::backtracking (begin_swept
/// also in the first step without it), by the thread that steps.
namespace poise::simulation {

/// Half the least extent of a body: it is fast if it moves farther in a step, and may leave its swept bound by as much.
double swept_slack_m(const SceneView& scene, std::size_t slot);

/// *predict*, first: forgets the last step's bounds.
void begin_swept(const PredictInput& input, SweptBounds& swept);

/// *predict*, for each living body: is it fast, that is, does it move farther in the step than half its least extent?
/// Then it has its swept bound now.
bool sweep_if_fast(const PredictInput& input, std::uint32_t slot, SweptBounds& swept);

/// *coarse*, last: takes the pairs with a fast body out of refinement. Those that touch already have a contact, the
/// exact one of a ball or else that of their deepest level; those that overlap stay ordinary pairs, with their skin for
/// a margin; all others wait for solve_swept.
void take_swept_pairs(const CoarseInput& input, PairTable& table, std::span<collision::FrontPool> pools,
                      parallel::Executor& executor);

/// *solve*, last: finds what meets on the trajectories that the solvers have left, gives each impact one impulse in
/// order of time (ties in canonical order), and stops bodies where they were hit until the end of the step. A body
/// whose trajectory is not the one that was swept stops before it leaves its bound. `scratch` becomes empty.
void solve_swept(const SolveInput& input, Velocities& velocities, collision::FrontPool& scratch, FrameReport& report,
                 parallel::Executor& executor);

}  // namespace poise::simulation
