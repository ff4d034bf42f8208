// SPDX-License-Identifier: MIT
#pragma once

#include "frame/solve.h"

/// Bodies that a step would have taken out of the range of BodyState: they are at rest where they were before it.
namespace poise::simulation {

/// Between *integrate* and *publish*: what contacts gave to these bodies (slots in ascending order) counts as nothing,
/// in what is published and in what the next step begins with, since it may be no number.
void forget_contacts_of(std::span<const std::uint32_t> slots, const PairTable& table, const Manifolds& manifolds,
                        PointCache& points, Velocities& velocities);

}  // namespace poise::simulation
