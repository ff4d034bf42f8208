// SPDX-License-Identifier: MIT
#pragma once

#include "collision/time_of_impact/conservative_advancement.h"
#include "frame/refine/refine_level.h"

namespace poise::simulation {

/// The wrench of two bodies that have met: the one contact where a ball meets something, else that of the polygons
/// where the two are then, if these agree with the contact about the side. `scratch` becomes empty.
collision::PairContact contact_where_met(const PairRefiner& refiner, const ActivePair& pair,
                                         const collision::TimeOfImpact& impact, collision::FrontPool& scratch);

}  // namespace poise::simulation
