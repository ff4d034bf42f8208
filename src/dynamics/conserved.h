// SPDX-License-Identifier: MIT
#pragma once

#include "dynamics/body_store.h"
#include "poise/world.h"

namespace poise::dynamics {

/// Sums over the bodies in slots [begin, end) that are not static, in slot order; potential energy is -m g . x.
Conserved conserved_sums(const BodyStore& bodies, const Vec3& gravity_mps2, std::size_t begin, std::size_t end);

}  // namespace poise::dynamics
