// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "frame/coarse.h"
#include "poise/scheduler/policy.h"
#include "world/learned_gains.h"

namespace poise::simulation {

/// What is expected of the levels of a pair, each from 0 to the deepest: the numbers behind a scheduler::PairChain.
struct ExpectedLevels {
  std::array<float, kPolygonBin + 1> error_m{};          ///< of the separation
  std::array<float, kPolygonBin + 1> ended{};            ///< probability that the pair is found separated by then
  std::array<float, kPolygonBin + 1> lifetime_frames{};  ///< for which what is found is valid, in [1, kMostLifetime]
};

/// Chosen: a pair at rest is valid for as long as it rests, and is not worth more than this for that.
inline constexpr double kMostLifetime = 64;

/// Probability that what a level finds of a pair expires in a frame, by the motion of its bodies against each other, in
/// [1 / kMostLifetime, 1].
double hazard_by_motion(const ActivePair& pair);

/// Replaces the expected errors, which are protrusions, by what was learned of the pair's shapes (null: nothing), to
/// the share Policy::learning, and fills the rest. An estimate is the mean over what was observed and kPriorPairs pairs
/// that did as the protrusion, the chance of ending and the motion say.
void expect_as_learned(const ShapePairGains* gains, const scheduler::Policy& policy, double hazard, std::size_t deepest,
                       ExpectedLevels& expected);

/// Chosen.
inline constexpr double kPriorPairs = 16;

}  // namespace poise::simulation
