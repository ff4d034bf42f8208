// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "collision/time_of_impact/conservative_advancement.h"
#include "frame/world_state.h"

namespace poise::simulation {

/// Half the least extent of a body: it is fast if it moves farther in a step, and may leave the way that was swept by
/// as much.
double swept_slack_m(const WorldState& world, std::size_t slot);

/// Brings a pair to its deepest level on one worker, and forgets the front.
void refine_whole(WorldState& world, ActivePair& pair, collision::LevelContact& found, int worker);

/// The wrench of two bodies that have met: the one contact where a ball meets something, else that of the polygons
/// where the two stand, if these agree with the contact about the side. Uses the poses of the frame and the pool of
/// worker 0; puts the poses back.
collision::PairContact contact_where_met(WorldState& world, const ActivePair& pair,
                                         const collision::TimeOfImpact& impact);

}  // namespace poise::simulation
