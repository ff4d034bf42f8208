// SPDX-License-Identifier: MIT
#pragma once

#include "accuracy/accuracy_case.h"

namespace poise::accuracy {

/// Two elastic gases of different mass in a closed box, one of them hot at the start: equal mean energies.
Status two_gases(Context& context);
/// Rings of balls: one that spins as a whole, and two that collide.
Status spinning_rings(Context& context);
/// A million impacts of elastic balls in a closed box.
Status million_impacts(Context& context);

}  // namespace poise::accuracy
